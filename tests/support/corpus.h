// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

/// Real scans for tests that want them. They are not part of the project: the folder is given by
/// NACRE_MESHES or stands beside the source tree; a test skips when it is not there.
namespace nacre::corpus {

inline std::filesystem::path folder() {
  if (const char* named = std::getenv("NACRE_MESHES")) return named;
  return std::filesystem::path(NACRE_SOURCE_DIR) / ".." / "shared" / "meshes";
}

inline std::filesystem::path mesh(const std::string& name) { return folder() / name; }
inline bool has(const std::string& name) { return std::filesystem::exists(mesh(name)); }

}  // namespace nacre::corpus

#define NACRE_SKIP_WITHOUT(name) \
  if (!nacre::corpus::has(name)) GTEST_SKIP() << "needs the test mesh " << (name)
