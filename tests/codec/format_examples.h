// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

/// What docs/FORMAT.md prints as examples: blocks between ```NAME and ```.
namespace nacre::format_examples {

/// The lines of each block of one name; text after # is a remark and left out.
inline std::vector<std::vector<std::string>> blocks(const std::string& name) {
  std::ifstream document(NACRE_SOURCE_DIR "/docs/FORMAT.md");
  std::vector<std::vector<std::string>> found;
  bool inside = false;
  for (std::string line; std::getline(document, line);) {
    if (line.rfind("```", 0) == 0) {
      inside = !inside && line == "```" + name;
      if (inside) found.emplace_back();
    } else if (inside) {
      found.back().push_back(line.substr(0, line.find('#')));
    }
  }
  return found;
}

/// The streams, and with another name parts of streams: hex bytes.
inline std::vector<std::vector<std::uint8_t>> streams(const std::string& name = "hex") {
  std::vector<std::vector<std::uint8_t>> found;
  for (const auto& lines : blocks(name)) {
    found.emplace_back();
    for (const std::string& line : lines) {
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        if (line[i] == ' ') continue;
        found.back().push_back(
            static_cast<std::uint8_t>(std::strtoul(line.substr(i, 2).c_str(), nullptr, 16)));
        ++i;
      }
    }
  }
  return found;
}

/// The positions the first stream decodes to: three hexadecimal floating point numbers a line.
inline std::vector<std::array<double, 3>> positions() {
  std::vector<std::array<double, 3>> found;
  for (const auto& lines : blocks("positions")) {
    for (const std::string& line : lines) {
      std::array<double, 3> p{};
      const char* at = line.c_str();
      for (double& x : p) {
        char* end = nullptr;
        x = std::strtod(at, &end);
        at = end;
      }
      found.push_back(p);
    }
  }
  return found;
}

}  // namespace nacre::format_examples
