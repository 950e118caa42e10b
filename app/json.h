// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "remesh/remesh.h"

/// JSON pieces that more than one verb writes. Slow to compile: for source files only. The
/// functions are in report.cpp.
namespace nacre::app {

using Json = nlohmann::ordered_json;  // keys stay in the order in which they were set

/// Indented text with a final line end. What is not finite becomes null, and a byte that is not
/// UTF-8 (of a file's name) U+FFFD.
[[nodiscard]] std::string dump_json(const Json& json);
[[nodiscard]] Json point_json(const Vec3& point);
[[nodiscard]] Json clean_json(const remesh::CleanReport& clean);
[[nodiscard]] Json pieces_json(const std::vector<remesh::PieceReport>& pieces);

}  // namespace nacre::app
