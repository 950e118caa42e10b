// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/glob.h"

#include <algorithm>
#include <vector>

namespace nacre::app::batch {
namespace {

using Parts = std::vector<std::string_view>;

Parts split(std::string_view path) {
  Parts parts;
  for (;;) {
    const std::size_t slash = path.find('/');
    parts.push_back(path.substr(0, slash));
    if (slash == std::string_view::npos) return parts;
    path.remove_prefix(slash + 1);
  }
}

/// One part. Going back to the last star only is enough and keeps this quadratic at worst.
bool part_match(std::string_view pattern, std::string_view text) {
  std::size_t p = 0, t = 0, star = std::string_view::npos, resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++resume;
    } else {
      return false;
    }
  }
  return std::all_of(pattern.begin() + static_cast<std::ptrdiff_t>(p), pattern.end(),
                     [](char c) { return c == '*'; });
}

}  // namespace

bool glob_match(std::string_view pattern, std::string_view path) {
  if (pattern.find('/') == std::string_view::npos && pattern != "**") {
    return part_match(pattern, path.substr(path.rfind('/') + 1));
  }
  const Parts patterns = split(pattern), parts = split(path);
  // reachable[t]: the patterns so far match the first t parts.
  std::vector<char> reachable(parts.size() + 1, 0);
  reachable[0] = 1;
  for (const std::string_view p : patterns) {
    std::vector<char> next(parts.size() + 1, 0);
    for (std::size_t t = 0; t <= parts.size(); ++t) {
      if (p == "**") {
        next[t] = static_cast<char>(reachable[t] || (t > 0 && next[t - 1]));
      } else if (t > 0) {
        next[t] = static_cast<char>(reachable[t - 1] && part_match(p, parts[t - 1]));
      }
    }
    reachable = std::move(next);
  }
  return reachable.back() != 0;
}

}  // namespace nacre::app::batch
