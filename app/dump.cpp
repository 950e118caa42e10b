// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/dump.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>
#include <utility>

#include "app/files.h"
#include "app/picture.h"

namespace nacre::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPictureName = "picture.png";
constexpr int kOnePanel = 800, kManyPanels = 480;  // pixels

Error cannot_write(const fs::path& folder, const std::string& what) {
  return {ErrorCode::kCannotWrite, fmt::format("{}: {}", folder.string(), what)};
}

std::string level_name(std::size_t level) { return fmt::format("level-{}.ply", level); }

std::string count_text(const DumpMesh& dump) {
  return fmt::format("{} vertices, {} faces", dump.mesh.positions.size(),
                     dump.mesh.triangles.size());
}

}  // namespace

Dumper::Dumper(DumpSettings settings, bool overwrite)
    : settings_(std::move(settings)), overwrite_(overwrite) {}

fs::path Dumper::folder_of(DumpStage stage) const {
  const auto place = static_cast<std::size_t>(stage);
  return settings_.work_dir / fmt::format("{:02}-{}", place + 1, kDumpStageNames[place]);
}

Result<void> Dumper::check() const {
  if (settings_.work_dir.empty()) return {};
  std::error_code ignored;
  fs::path there = settings_.work_dir;
  while (!there.empty() && !fs::exists(there, ignored)) there = there.parent_path();
  if (there.empty()) there = ".";
  if (!fs::is_directory(there, ignored)) return cannot_write(there, "is not a folder");
  if (access(there.c_str(), W_OK | X_OK) != 0)
    return cannot_write(there, "may not be written; choose another --work-dir");
  if (overwrite_) return {};
  for (std::size_t i = 0; i < kDumpStageNames.size(); ++i) {
    const auto stage = static_cast<DumpStage>(i);
    const fs::path folder = folder_of(stage);
    if (settings_.wants(stage) && fs::exists(folder, ignored) && !fs::is_empty(folder, ignored))
      return Error{ErrorCode::kBadInput,
                   fmt::format("{}: is not empty; use -f to overwrite its files", folder.string())};
  }
  return {};
}

void Dumper::input(const Scan& scan) {
  if (!settings_.wants(DumpStage::kInput)) return;
  DumpMesh dump;
  dump.mesh = scan;
  dump.comments = {"input: as read"};
  write(DumpStage::kInput, {{"scan.ply", std::move(dump)}});
}

remesh::Observer Dumper::observer() {
  remesh::Observer observer;
  const bool levels = settings_.wants(DumpStage::kNormalMesh);
  if (settings_.wants(DumpStage::kClean) || levels)
    observer.cleaned = [this](const remesh::CleanScan& scan) { cleaned(scan); };
  if (settings_.wants(DumpStage::kBase) || settings_.wants(DumpStage::kParameterisation))
    observer.base = [this](const Scan& scan, const remesh::Parameterisation& map) {
      base(scan, map);
    };
  if (levels)
    observer.normal_mesh = [this](const SemiRegularMesh& mesh, std::span<const std::uint8_t> kind) {
      normal_mesh(mesh, kind);
    };
  return observer;
}

Result<void> Dumper::finish() {
  flush_base();
  return first_error_;
}

void Dumper::cleaned(const remesh::CleanScan& scan) {
  if (settings_.wants(DumpStage::kClean))
    write(DumpStage::kClean, {{"clean.ply", dump_clean(scan)}});
  if (!settings_.wants(DumpStage::kNormalMesh)) return;
  Result<FoldCheck> check = FoldCheck::build(scan.scan);
  if (check) {
    scan_ = std::move(*check);
  } else {
    fail(check.error());
  }
}

void Dumper::base(const Scan& scan, const remesh::Parameterisation& map) {
  if (settings_.wants(DumpStage::kBase)) append(base_, dump_base(scan, map, base_faces_));
  if (settings_.wants(DumpStage::kParameterisation))
    append(parameterisation_, dump_parameterisation(scan, map, base_faces_));
  base_faces_ += map.base.triangles.size();
}

void Dumper::flush_base() {
  DumpMesh base = std::exchange(base_, {}), map = std::exchange(parameterisation_, {});
  if (!base.mesh.triangles.empty()) write(DumpStage::kBase, {{"base.ply", std::move(base)}});
  if (!map.mesh.triangles.empty())
    write(DumpStage::kParameterisation, {{"map.ply", std::move(map)}});
}

void Dumper::normal_mesh(const SemiRegularMesh& mesh, std::span<const std::uint8_t> kind) {
  flush_base();
  if (!scan_) return;
  std::vector<Named> levels;
  for (int level = 0; level <= mesh.level_count; ++level) {
    Result<DumpMesh> dump = dump_level(mesh, level, kind, *scan_);
    if (!dump) return fail(dump.error());
    levels.push_back({level_name(static_cast<std::size_t>(level)), std::move(*dump)});
  }
  write(DumpStage::kNormalMesh, levels);
}

void Dumper::write(DumpStage stage, const std::vector<Named>& meshes) {
  const fs::path folder = folder_of(stage);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(cannot_write(folder, error.message()));
  if (overwrite_ && stage == DumpStage::kNormalMesh) {  // the levels of a deeper run
    for (std::size_t i = meshes.size(); fs::remove(folder / level_name(i), error); ++i) continue;
  }
  std::vector<Panel> panels;
  for (const Named& named : meshes) {
    write_file(folder / named.name, to_ply(named.dump));
    Panel& panel = panels.emplace_back();
    panel.mesh = &named.dump.mesh;
    panel.vertex_color = named.dump.vertex_color;
    // Levels show their details; where a face's colour says more, it is the only one in the file.
    if (stage != DumpStage::kNormalMesh) panel.face_color = named.dump.face_color;
    panel.caption = fs::path(named.name).stem().string() + "\n" + count_text(named.dump);
    if (stage == DumpStage::kBase) panel.wire = panel.mesh;
  }
  PictureOptions options;
  options.panel_width = options.panel_height = meshes.size() == 1 ? kOnePanel : kManyPanels;
  options.supersampling = 2;
  write_file(folder / kPictureName, render_png(panels, options));
}

void Dumper::write_file(const fs::path& file, const Result<std::vector<std::uint8_t>>& bytes) {
  if (!bytes) return fail(in_file(bytes.error(), file));
  fail(write_output(file, *bytes, overwrite_));
}

void Dumper::fail(const Result<void>& result) {
  if (!result && first_error_) first_error_ = result;
}

}  // namespace nacre::app
