// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/dump.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>
#include <utility>

#include "app/files.h"
#include "app/npy.h"
#include "app/picture.h"
#include "app/report.h"
#include "app/sha256.h"
#include "codec/recode.h"
#include "codec/symbols.h"

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

/// Whether a stage's PLY can be edited to go on from, beside its arrays.
bool has_editable_ply(DumpStage stage) {
  return stage <= DumpStage::kBase || stage == DumpStage::kNormalMesh;
}

bool is_empty_or_missing(const fs::path& folder) {
  std::error_code ignored;
  return !fs::exists(folder, ignored) || fs::is_empty(folder, ignored);
}

/// The finest mesh; quality of a vertex: the length of its detail. Base vertices have none.
Result<DumpMesh> dump_details(const SemiRegularMesh& mesh, const StageFiles& files) {
  Result<TriangleMesh> finest = to_triangles(mesh);
  if (!finest) return finest.error();
  DumpMesh dump;
  dump.mesh = std::move(*finest);
  dump.comments = {
      "quality of a vertex is the length of its detail; colour runs from grey (none) "
      "to orange (the longest of its level)"};
  dump.vertex_quality.assign(mesh.base_vertex_count, 0);
  dump.vertex_color.assign(mesh.base_vertex_count, kBoundaryBlue);
  for (const StageFile& file : files) {
    if (!file.name.starts_with("band-")) continue;
    const auto details = from_npy<Vec3>(file.bytes);
    if (!details) return details.error();
    double longest = 0;
    for (const Vec3& d : *details) longest = std::max(longest, norm(d));
    for (const Vec3& d : *details) {
      const double share = longest > 0 ? std::sqrt(norm(d) / longest) : 0;
      Rgb color{};
      for (std::size_t k = 0; k < 3; ++k)
        color[k] = static_cast<std::uint8_t>(
            std::lround(kNormalGrey[k] + share * (kVectorOrange[k] - kNormalGrey[k])));
      dump.vertex_quality.push_back(static_cast<float>(norm(d)));
      dump.vertex_color.push_back(color);
    }
  }
  return dump;
}

}  // namespace

Dumper::Dumper(DumpSettings settings, bool overwrite)
    : settings_(std::move(settings)), overwrite_(overwrite) {}

fs::path Dumper::folder_of(DumpStage stage) const {
  return settings_.work_dir / stage_folder_name(stage);
}

bool Dumper::is_to_be_written(DumpStage stage) const {
  if (settings_.until && stage > *settings_.until) return false;
  return settings_.wants(stage) && !starts_at_or_after(stage);
}

bool Dumper::is_current(DumpStage stage) const {
  const auto record = read_record(folder_of(stage));
  if (!record || record->stage != stage || record->key != keys_.key(stage)) return false;
  const auto folder = open_stage(folder_of(stage));
  return folder && folder->edited.empty() && folder->hash == record->hash;
}

/// Without the key, which is known once the scan is read, a stage may yet turn out to be current.
Result<void> Dumper::check_folder(DumpStage stage, bool known_key) const {
  const fs::path folder = folder_of(stage);
  if (!is_to_be_written(stage) || is_empty_or_missing(folder)) return {};
  const auto record = read_record(folder);
  if (!record)
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: is not empty; use -f to overwrite its files", folder.string())};
  if (!known_key || is_current(stage)) return {};
  const auto there = open_stage(folder);
  const bool edited = there && !there->edited.empty();
  return Error{ErrorCode::kBadInput,
               edited ? fmt::format("{}: was edited; use --from {} to go on from it, or -f to "
                                    "overwrite it",
                                    folder.string(), folder.string())
                      : fmt::format("{}: is of another scan, other options, or another build; use "
                                    "-f to overwrite it",
                                    folder.string())};
}

Result<void> Dumper::open_entry() {
  Result<StageFolder> entry = open_stage(settings_.from);
  if (!entry) return entry.error();
  entry_ = std::move(*entry);
  if (settings_.until && *settings_.until <= entry_->record.stage)
    return Error{ErrorCode::kBadInput,
                 fmt::format("--until {} lies before --from {}",
                             kDumpStageNames[static_cast<std::size_t>(*settings_.until)],
                             settings_.from.string())};
  // From its curves a run measures them anew.
  if (entry_->record.stage == DumpStage::kRdCurves && !entry_->edited.empty())
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: was edited, but is to be looked at only; go on from "
                             "06-coefficients, or from 08-steps with steps of your choice",
                             settings_.from.string())};
  Result<std::optional<StageFolder>> beside = open_beside(*entry_);
  if (!beside) return beside.error();
  beside_ = std::move(*beside);
  return {};
}

Result<void> Dumper::check() {
  if (!settings_.from.empty()) {
    if (Result<void> ok = open_entry(); !ok) return ok;
  }
  if (settings_.work_dir.empty()) return {};
  std::error_code ignored;
  fs::path there = settings_.work_dir;
  while (!there.empty() && !fs::exists(there, ignored)) there = there.parent_path();
  if (there.empty()) there = ".";
  if (!fs::is_directory(there, ignored)) return cannot_write(there, "is not a folder");
  if (access(there.c_str(), W_OK | X_OK) != 0)
    return cannot_write(there, "may not be written; choose another --work-dir");
  if (overwrite_) return {};
  for (std::size_t i = 0; i < kDumpStageNames.size(); ++i)
    if (Result<void> ok = check_folder(static_cast<DumpStage>(i), false); !ok) return ok;
  return {};
}

Result<void> Dumper::begin(const Scan& scan) {
  last_ = std::chrono::steady_clock::now();
  if (settings_.work_dir.empty()) return {};
  std::string origin;
  for (const StageFile& file : files_of(scan)) origin += sha256(file.bytes);
  if (entry_) {
    origin += stage_folder_name(entry_->record.stage) + entry_->hash;
    if (beside_) origin += beside_->hash;
    last_hash_ = entry_->hash;
  }
  keys_.set_origin(std::move(origin));
  if (overwrite_) return {};
  for (std::size_t i = 0; i < kDumpStageNames.size(); ++i)
    if (Result<void> ok = check_folder(static_cast<DumpStage>(i), true); !ok) return ok;
  return {};
}

std::optional<StageFolder> Dumper::reusable() const {
  if (settings_.work_dir.empty()) return std::nullopt;
  constexpr std::array kLatestFirst = {DumpStage::kNormalMesh, DumpStage::kParameterisation,
                                       DumpStage::kClean};
  for (const DumpStage stage : kLatestFirst) {
    if (starts_at_or_after(stage) || (settings_.until && stage > *settings_.until)) continue;
    bool complete = is_current(stage);
    for (std::size_t i = 0; i < static_cast<std::size_t>(stage) && complete; ++i) {
      const auto earlier = static_cast<DumpStage>(i);
      // The scan is at hand: 01-input can be written without a stage before it.
      complete = earlier == DumpStage::kInput || !is_to_be_written(earlier) || is_current(earlier);
    }
    if (!complete) continue;
    Result<StageFolder> folder = open_stage(folder_of(stage));
    if (folder) return std::move(*folder);
  }
  return std::nullopt;
}

double Dumper::lap() {
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last_).count();
  last_ = now;
  return seconds;
}

void Dumper::input(const Scan& scan) {
  if (!is_to_be_written(DumpStage::kInput)) return;
  DumpMesh dump;
  dump.mesh = scan;
  dump.comments = {"input: as read"};
  Pending pending{files_of(scan), {}, lap()};
  pending.meshes.push_back({"scan.ply", std::move(dump)});
  write(DumpStage::kInput, std::move(pending));
}

remesh::Observer Dumper::observer() {
  remesh::Observer observer;
  const bool levels = is_to_be_written(DumpStage::kNormalMesh);
  if (is_to_be_written(DumpStage::kClean) || levels)
    observer.cleaned = [this](const remesh::CleanScan& scan) { cleaned(scan); };
  if (is_to_be_written(DumpStage::kBase) || is_to_be_written(DumpStage::kParameterisation))
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
  flush();
  return first_error_;
}

void Dumper::surface(const Scan& cleaned) {
  if (!is_to_be_written(DumpStage::kNormalMesh)) return;
  Result<FoldCheck> check = FoldCheck::build(cleaned);
  if (check) {
    scan_ = std::move(*check);
  } else {
    fail(check.error());
  }
}

void Dumper::cleaned(const remesh::CleanScan& scan) {
  const double seconds = lap();
  if (is_to_be_written(DumpStage::kClean)) {
    facts_.clean = scan.report;
    facts_.pieces = scan.pieces;
    Pending pending{files_of(scan), {}, seconds};
    pending.meshes.push_back({"clean.ply", dump_clean(scan)});
    write(DumpStage::kClean, std::move(pending));
  }
  surface(scan.scan);
}

void Dumper::base(const Scan& scan, const remesh::Parameterisation& map) {
  const double seconds = lap();
  const auto add = [&](Pending& pending, StageFiles files, DumpMesh dump, const char* name) {
    pending.files = std::move(files);
    if (pending.meshes.empty()) pending.meshes.push_back({name, {}});
    append(pending.meshes.front().dump, std::move(dump));
  };
  if (is_to_be_written(DumpStage::kBase)) {
    add(base_, base_files_of(scan, map.base), dump_base(scan, map, base_faces_), "base.ply");
    base_.seconds = seconds;
  }
  if (is_to_be_written(DumpStage::kParameterisation))
    add(parameterisation_, files_of(scan, map), dump_parameterisation(scan, map, base_faces_),
        "map.ply");
  base_faces_ += map.base.triangles.size();
}

void Dumper::flush() {
  Pending base = std::exchange(base_, {}), map = std::exchange(parameterisation_, {}),
          mesh = std::exchange(normal_mesh_, {});
  if (!base.empty()) write(DumpStage::kBase, std::move(base));
  if (!map.empty()) write(DumpStage::kParameterisation, std::move(map));
  if (!mesh.empty()) write(DumpStage::kNormalMesh, std::move(mesh));
}

void Dumper::normal_mesh(const SemiRegularMesh& mesh, std::span<const std::uint8_t> kind) {
  const double seconds = lap();
  if (!scan_) return;
  Pending pending{files_of(mesh), {}, seconds};
  pending.files.push_back({"kind.npy", to_npy(kind)});
  for (int level = 0; level <= mesh.level_count; ++level) {
    Result<DumpMesh> dump = dump_level(mesh, level, kind, *scan_);
    if (!dump) return fail(dump.error());
    pending.meshes.push_back({level_name(static_cast<std::size_t>(level)), std::move(*dump)});
  }
  normal_mesh_ = std::move(pending);
}

void Dumper::coefficients(const SemiRegularMesh& mesh, wavelet::Transform transform) {
  if (!is_to_be_written(DumpStage::kCoefficients)) return;
  last_ = std::chrono::steady_clock::now();
  facts_.transform = transform;
  Result<StageFiles> files = coefficient_files_of(mesh, transform);
  if (!files) return fail(files.error());
  Pending pending{std::move(*files), {}, lap()};
  Result<DumpMesh> dump = dump_details(mesh, pending.files);
  if (!dump) return fail(dump.error());
  pending.meshes.push_back({"details.ply", std::move(*dump)});
  write(DumpStage::kCoefficients, std::move(pending));
}

void Dumper::coded(const codec::Encoded& encoded, const codec::EncodeOptions& options) {
  const double seconds = lap();
  if (is_to_be_written(DumpStage::kRdCurves))
    write(DumpStage::kRdCurves, {files_of(encoded.report), {}, 0});
  if (is_to_be_written(DumpStage::kSteps)) {
    const auto choice = codec::choice_of(encoded, options);
    if (!choice) return fail(choice.error());
    write(DumpStage::kSteps, {files_of(*choice), {}, seconds});
  }
  if (is_to_be_written(DumpStage::kSymbols)) {
    const auto symbols = codec::read_symbols(encoded.bytes);
    if (!symbols) return fail(symbols.error());
    write(DumpStage::kSymbols, {symbol_files_of(*symbols, encoded.bytes), {}, 0});
  }
  if (is_to_be_written(DumpStage::kStream))
    write(DumpStage::kStream, {{{"stream.ncr", encoded.bytes}}, {}, 0});
}

void Dumper::write(DumpStage stage, Pending pending) {
  const fs::path folder = folder_of(stage);
  if (is_current(stage)) {
    last_hash_ = read_record(folder)->hash;
    return;
  }
  for (const Named& named : pending.meshes) {
    Result<std::vector<std::uint8_t>> bytes = to_ply(named.dump);
    if (!bytes) return fail(in_file(bytes.error(), folder / named.name));
    if (has_editable_ply(stage)) pending.files.push_back({named.name, std::move(*bytes)});
  }
  StageRecord record;
  record.stage = stage;
  record.parent = last_hash_;
  record.key = keys_.key(stage);
  record.options = keys_.options(stage);
  record.facts = to_text(facts_);
  record.seconds = pending.seconds;
  record.peak_bytes = peak_resident_bytes();
  const Result<std::string> hash =
      write_stage(folder, std::move(record), pending.files, overwrite_);
  if (!hash) return fail(hash.error());
  last_hash_ = *hash;
  if (!has_editable_ply(stage))
    for (const Named& named : pending.meshes) write_file(folder / named.name, to_ply(named.dump));
  if (overwrite_ && stage == DumpStage::kNormalMesh) {  // the levels of a deeper run
    std::error_code error;
    for (std::size_t i = pending.meshes.size(); fs::remove(folder / level_name(i), error); ++i)
      continue;
  }
  if (!pending.meshes.empty()) write_pictures(stage, pending.meshes);
  last_ = std::chrono::steady_clock::now();
}

void Dumper::write_pictures(DumpStage stage, const std::vector<Named>& meshes) {
  std::vector<Panel> panels;
  for (const Named& named : meshes) {
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
  write_file(folder_of(stage) / kPictureName, render_png(panels, options));
}

void Dumper::write_file(const fs::path& file, const Result<std::vector<std::uint8_t>>& bytes) {
  if (!bytes) return fail(in_file(bytes.error(), file));
  fail(write_output(file, *bytes, overwrite_));
}

void Dumper::fail(const Result<void>& result) {
  if (!result && first_error_) first_error_ = result;
}

}  // namespace nacre::app
