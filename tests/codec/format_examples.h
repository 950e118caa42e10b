// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

/// The streams printed in docs/FORMAT.md: lines of hex bytes between ```hex and ```; text after #
/// is a remark.
namespace nacre::format_examples {

inline std::vector<std::vector<std::uint8_t>> streams() {
  std::ifstream document(NACRE_SOURCE_DIR "/docs/FORMAT.md");
  std::vector<std::vector<std::uint8_t>> found;
  bool inside = false;
  for (std::string line; std::getline(document, line);) {
    if (line.rfind("```", 0) == 0) {
      inside = line == "```hex";
      if (inside) found.emplace_back();
      continue;
    }
    if (!inside) continue;
    line = line.substr(0, line.find('#'));
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      if (line[i] == ' ') continue;
      found.back().push_back(static_cast<std::uint8_t>(std::stoul(line.substr(i, 2), nullptr, 16)));
      ++i;
    }
  }
  return found;
}

}  // namespace nacre::format_examples
