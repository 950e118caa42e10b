// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/files.h"
#include "app/npy.h"
#include "app/stage.h"

/// Arrays as files of a stage's payload.
namespace nacre::app {

template <class Row>
[[nodiscard]] StageFile array_file(std::string name, std::span<const Row> rows) {
  return {std::move(name), to_npy(rows)};
}
template <class Row>
[[nodiscard]] StageFile array_file(std::string name, const std::vector<Row>& rows) {
  return array_file(std::move(name), std::span<const Row>(rows));
}

/// Errors   kUnreadableFile, with the file's name: it is not there, or holds something else.
template <class Row>
[[nodiscard]] Result<std::vector<Row>> array_of(const StageFolder& stage, const std::string& name) {
  const auto bytes = stage.file(name);
  if (!bytes) return bytes.error();
  auto rows = from_npy<Row>(*bytes);
  if (!rows) return in_file(rows.error(), stage.folder / name);
  return rows;
}

}  // namespace nacre::app
