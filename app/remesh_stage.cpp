// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/remesh_stage.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/files.h"
#include "app/semi_regular.h"
#include "base/topology.h"
#include "io/io.h"
#include "wavelet/wavelet.h"

namespace nacre::app {
namespace {

/// The options that each stage of the remesher depends on. Bounds that the goal sets count only
/// where the user has not said it all: then a change of the goal leaves these stages as they are.
void set_stage_options(const RemeshSettings& settings, Dumper& dumper) {
  dumper.set_options(DumpStage::kClean,
                     fmt::format("{{\"repair\":\"{}\",\"semi_regular\":{}}}",
                                 name_of(settings.repair), settings.semi_regular));
  const bool free_base = settings.base_vertices == 0, free_levels = settings.levels == 0;
  dumper.set_options(
      DumpStage::kBase,
      fmt::format("{{\"base_vertices\":{},\"least_base_vertices\":{},\"most_base_vertices\":{},"
                  "\"levels\":{},\"least_triangles\":{},\"keep_triangles\":{},\"few_trials\":{}}}",
                  settings.base_vertices, free_base ? settings.least_base_vertices : 0,
                  free_base ? settings.most_base_vertices : 0, settings.levels,
                  free_levels ? settings.least_triangles : 0, settings.keep_triangles,
                  settings.few_trials));
}

/// A run of the remesher that may begin in its middle and end before its end.
class Steps {
 public:
  Steps(const RemeshSettings& settings, Prepared& prepared, Console& console, Dumper* dumper)
      : prepared_(prepared),
        context_(console.context()),
        dumper_(dumper),
        is_semi_regular_(settings.semi_regular) {
    options_ = remesh_options(settings);
    if (dumper != nullptr) options_.observer = dumper->observer();
  }

  /// What a dumped stage holds, and the one that it needs beside it (null: none).
  Result<void> start_from(const StageFolder& stage, const StageFolder* beside);
  /// From there, or from the scan, to the end or to where the dumper says.
  Result<void> run();

 private:
  bool stops_after(DumpStage stage) {
    if (dumper_ == nullptr || !dumper_->stops_after(stage)) return false;
    prepared_.stopped_after = stage;
    return true;
  }
  Result<void> recognise();
  Result<void> start_from_mesh(const StageFolder& stage, const StageFolder* beside);
  Result<void> start_from_map(const StageFolder& stage, const StageFolder* beside);
  Result<void> clean();
  Result<void> map();
  Result<void> pierce();
  void lap(const char* stage) {
    clock_.finish(stage);
    prepared_.remesh.costs = clock_.costs();
  }

  Prepared& prepared_;
  RunContext context_;
  Dumper* dumper_;
  bool is_semi_regular_;
  StageClock clock_;
  remesh::Options options_;
  std::optional<remesh::CleanScan> cleaned_;
  std::optional<remesh::MappedScan> mapped_;
  bool is_done_ = false;
};

Result<void> Steps::start_from_mesh(const StageFolder& stage, const StageFolder* beside) {
  // Symbols and the stream need no mesh.
  if (stage.record.stage < DumpStage::kSymbols) {
    Result<SemiRegularMesh> mesh = mesh_from(beside != nullptr ? *beside : stage);
    if (!mesh) return mesh.error();
    prepared_.remesh.mesh = std::move(*mesh);
  }
  const StageFacts facts = facts_from(stage.record.facts);
  prepared_.remesh.clean = facts.clean;
  prepared_.remesh.bands = facts.bands;
  prepared_.remesh.pieces = facts.pieces;
  if (dumper_ != nullptr) dumper_->facts() = facts;
  is_done_ = true;
  return {};
}

Result<void> Steps::start_from_map(const StageFolder& stage, const StageFolder* beside) {
  // The map was made together with the base mesh: both are in 04, and 03 says what was moved.
  Result<remesh::MappedScan> mapped = mapped_from(beside != nullptr ? *beside : stage);
  if (!mapped) return mapped.error();
  if (beside != nullptr) {
    if (Result<void> moved = move_base(stage, *mapped); !moved) return moved;
  }
  mapped_ = std::move(*mapped);
  const StageFacts facts = facts_from(stage.record.facts);
  prepared_.remesh.clean = facts.clean;
  if (dumper_ != nullptr) {
    dumper_->facts() = facts;
    dumper_->surface(*mapped_->scan);
    if (beside != nullptr && options_.observer.base)
      options_.observer.base(*mapped_->scan, mapped_->map);
  }
  return {};
}

Result<void> Steps::start_from(const StageFolder& stage, const StageFolder* beside) {
  switch (stage.record.stage) {
    case DumpStage::kInput:
      return {};
    case DumpStage::kClean: {
      Result<remesh::CleanScan> cleaned = clean_from(stage, options_.repair);
      if (!cleaned) return cleaned.error();
      cleaned_ = std::move(*cleaned);
      prepared_.remesh.clean = cleaned_->report;
      if (dumper_ == nullptr) return {};
      dumper_->facts().clean = cleaned_->report;
      dumper_->facts().pieces = cleaned_->pieces;
      dumper_->surface(cleaned_->scan);
      return {};
    }
    case DumpStage::kBase:
    case DumpStage::kParameterisation:
      return start_from_map(stage, beside);
    default:
      return start_from_mesh(stage, beside);
  }
}

/// DetailKind of each vertex of a mesh from elsewhere.
std::vector<std::uint8_t> detail_kinds(const SemiRegularMesh& mesh, const Topology& topology) {
  std::vector<std::uint8_t> kinds(mesh.positions.size(), 0);
  const auto pyramid = wavelet::analyze(topology, mesh.positions);
  if (!pyramid) return kinds;
  constexpr double kRounding = 1e-4;  // files with floats are as far from their normals
  std::size_t v = mesh.base_vertex_count;
  for (std::size_t j = 0; j < pyramid->bands.size(); ++j) {
    for (std::size_t e = 0; e < pyramid->bands[j].size(); ++e, ++v) {
      const Vec3& d = pyramid->bands[j][e];
      const bool is_normal = std::max(std::abs(d[1]), std::abs(d[2])) <= kRounding * norm(d);
      const bool is_boundary = topology.level(static_cast<int>(j)).edges[e].is_boundary();
      const auto kind = is_boundary ? remesh::DetailKind::kBoundary
                        : is_normal ? remesh::DetailKind::kNormal
                                    : remesh::DetailKind::kVector;
      kinds[v] = static_cast<std::uint8_t>(kind);
    }
  }
  return kinds;
}

/// In place of remeshing: the mesh is semi-regular already.
Result<void> Steps::recognise() {
  Result<SemiRegularMesh> mesh = recognise_subdivision(prepared_.source(), options_.levels);
  if (!mesh) return in_file(mesh.error(), prepared_.input.file);
  remesh::Remesh& out = prepared_.remesh;
  out.mesh = std::move(*mesh);
  const auto topology =
      Topology::build(out.mesh.base_triangles, out.mesh.base_vertex_count, out.mesh.level_count);
  if (!topology) return in_file(topology.error(), prepared_.input.file);
  const std::vector<std::uint8_t> kinds = detail_kinds(out.mesh, *topology);
  for (int level = 0; level < out.mesh.level_count; ++level) {
    const std::size_t begin = topology->level(level).vertex_count;
    remesh::BandReport band;
    band.vertices = topology->band_size(level);
    for (std::size_t i = begin; i < begin + band.vertices; ++i) band.normal_only += kinds[i] == 0;
    out.bands.push_back(band);
  }
  if (dumper_ != nullptr) {
    dumper_->surface(prepared_.source());
    if (options_.observer.normal_mesh) options_.observer.normal_mesh(out.mesh, kinds);
    dumper_->facts().levels = out.mesh.level_count;
    dumper_->facts().bands = out.bands;
    dumper_->flush();
  }
  is_done_ = true;
  lap("recognise");
  return {};
}

Result<void> Steps::clean() {
  Result<remesh::CleanScan> cleaned =
      remesh::clean(prepared_.scan, options_.repair, options_.small_extent);
  if (!cleaned) return in_file(cleaned.error(), prepared_.input.file);
  cleaned_ = std::move(*cleaned);
  prepared_.remesh.clean = cleaned_->report;
  if (options_.observer.cleaned) options_.observer.cleaned(*cleaned_);
  lap("clean");
  return {};
}

Result<void> Steps::map() {
  Result<remesh::MappedScan> mapped =
      remesh::map_onto_base(std::move(*cleaned_), options_, context_);
  if (!mapped) return in_file(mapped.error(), prepared_.input.file);
  mapped_ = std::move(*mapped);
  if (dumper_ != nullptr) {
    dumper_->facts().levels = mapped_->levels;
    dumper_->facts().is_kept = mapped_->is_kept;
    dumper_->facts().pieces = mapped_->pieces;
    dumper_->flush();
  }
  lap("base mesh");
  return {};
}

Result<void> Steps::pierce() {
  Result<remesh::Remesh> pierced = remesh::pierce_map(*mapped_, options_, context_);
  if (!pierced) return in_file(pierced.error(), prepared_.input.file);
  pierced->clean = prepared_.remesh.clean;
  pierced->costs = std::move(prepared_.remesh.costs);
  prepared_.remesh = std::move(*pierced);
  if (dumper_ != nullptr) {
    dumper_->facts().bands = prepared_.remesh.bands;
    dumper_->flush();
  }
  lap("piercing");
  return {};
}

Result<void> Steps::run() {
  if (is_semi_regular_ && !is_done_) {
    if (Result<void> ok = recognise(); !ok) return ok;
  }
  if (!is_done_ && !mapped_ && !cleaned_) {
    if (Result<void> ok = clean(); !ok || stops_after(DumpStage::kClean)) return ok;
  } else if (stops_after(DumpStage::kClean)) {
    return {};
  }
  if (!is_done_ && !mapped_) {
    if (Result<void> ok = map(); !ok) return ok;
  } else if (dumper_ != nullptr) {
    dumper_->flush();
  }
  if (stops_after(DumpStage::kBase) || stops_after(DumpStage::kParameterisation)) return {};
  if (!is_done_) {
    if (Result<void> ok = pierce(); !ok) return ok;
  }
  stops_after(DumpStage::kNormalMesh);
  return {};
}

Result<void> read(const std::filesystem::path& file, Prepared& prepared, StageClock& clock,
                  Console& console) {
  console.context().report("read", 0);
  Result<io::ReadResult> read = io::read_scan(file);
  if (!read) return in_file(read.error(), file);
  if (!has_area(read->scan)) {
    return Error{
        ErrorCode::kGeometryRefused,
        fmt::format("{}: no face has an area, so there is no surface to code", file.string())};
  }
  prepared.input = input_facts(file, *read);
  prepared.input.bbox_diagonal = bbox_diagonal(read->scan);
  prepared.scan = std::move(read->scan);
  clock.finish("read");
  if (!prepared.input.read.not_carried.empty()) {
    console.note(fmt::format("not carried: {}", fmt::join(prepared.input.read.not_carried, ", ")));
  }
  return check_cancelled(console);
}

/// Where the run starts: at the stage asked for, at one that is there already, or at the scan.
Result<void> enter(Dumper& dumper, Prepared& prepared, Steps& steps, Console& console) {
  if (const StageFolder* entry = dumper.entry()) {
    prepared.from = Reentry{stage_folder_name(entry->record.stage), entry->folder, entry->edited};
    if (const StageFolder* beside = dumper.beside()) {
      for (const std::string& name : beside->edited)
        prepared.from->edited.push_back("../" + stage_folder_name(beside->record.stage) + "/" +
                                        name);
    }
    console.note(describe(*prepared.from));
    if (entry->record.stage == DumpStage::kInput) {
      Result<Scan> scan = scan_from(*entry);
      if (!scan) return scan.error();
      (prepared.to_remesh ? *prepared.to_remesh : prepared.scan) = std::move(*scan);
      const Scan& source = prepared.source();
      prepared.input.vertices = prepared.input.goal_vertices = source.positions.size();
      prepared.input.faces = source.triangles.size();
      prepared.input.origin = source.origin;
      prepared.input.bbox_diagonal = bbox_diagonal(prepared.scan);
    }
  }
  if (Result<void> ok = dumper.begin(prepared.source()); !ok) return ok;
  dumper.input(prepared.source());
  if (const std::optional<StageFolder> there = dumper.reusable()) {
    console.detail(fmt::format("{} is as it would be made again: used", there->folder.string()));
    return steps.start_from(*there, nullptr);
  }
  if (dumper.entry() == nullptr) return {};
  return steps.start_from(*dumper.entry(), dumper.beside());
}

}  // namespace

Result<void> check_cancelled(const Console& console) {
  if (!console.cancelled()) return {};
  return Error{ErrorCode::kCancelled, "interrupted; nothing was written"};
}

Result<metric::Comparison> measure(const Scan& scan, const Scan& other, std::size_t samples,
                                   const std::filesystem::path& file, Console& console) {
  metric::Options options;
  options.samples = samples;
  Result<metric::Comparison> comparison = metric::compare(scan, other, options, console.context());
  if (!comparison) return surface_error(comparison.error(), file);
  return comparison;
}

std::string stopped_line(DumpStage stage, const DumpSettings& settings) {
  return fmt::format("stopped after {}: {}", stage_folder_name(stage),
                     (settings.work_dir / stage_folder_name(stage)).string());
}

remesh::Options remesh_options(const RemeshSettings& settings) {
  remesh::Options options;
  options.levels = settings.levels;
  options.base_vertices = settings.base_vertices;
  options.least_base_vertices = settings.least_base_vertices;
  options.most_base_vertices = settings.most_base_vertices;
  options.least_triangles = settings.least_triangles;
  options.keep_triangles = settings.keep_triangles;
  options.few_trials = settings.few_trials;
  options.repair = settings.repair;
  options.predict = wavelet::predict_at_need;
  return options;
}

Result<Prepared> read_input(const std::filesystem::path& file, StageClock& clock,
                            Console& console) {
  Prepared prepared;
  if (Result<void> ok = read(file, prepared, clock, console); !ok) return ok.error();
  return prepared;
}

Result<void> read_reference(const std::filesystem::path& file, Prepared& prepared,
                            Console& console) {
  if (file.empty()) return {};
  Result<io::ReadResult> read = io::read_scan(file);
  if (!read) return in_file(read.error(), file);
  if (!has_area(read->scan))
    return Error{ErrorCode::kGeometryRefused,
                 fmt::format("{}: no face has an area to measure against", file.string())};
  prepared.to_remesh = std::exchange(prepared.scan, std::move(read->scan));
  prepared.input.bbox_diagonal = bbox_diagonal(prepared.scan);
  return check_cancelled(console);
}

Result<void> remesh_input(Prepared& prepared, const RemeshSettings& settings, StageClock& clock,
                          Console& console, Dumper* dumper) {
  if (dumper != nullptr) set_stage_options(settings, *dumper);
  Steps steps(settings, prepared, console, dumper);
  Result<void> done;
  if (dumper != nullptr) done = enter(*dumper, prepared, steps, console);
  const bool stops_at_once = dumper != nullptr && dumper->stops_after(DumpStage::kInput);
  if (stops_at_once) prepared.stopped_after = DumpStage::kInput;
  if (done && !stops_at_once) done = steps.run();
  const Result<void> dumped = dumper != nullptr ? dumper->finish() : Result<void>();
  if (!done) return done.error();
  if (!dumped) return dumped.error();
  clock.finish("remesh", prepared.remesh.costs);
  return check_cancelled(console);
}

void note_remesh(const Prepared& prepared, Console& console) {
  const std::string cleaning = describe_cleaning(prepared.remesh.clean);
  if (!cleaning.empty()) console.note(cleaning);
  for (const std::string& line : describe_fallbacks(prepared.remesh.pieces)) console.warning(line);
}

}  // namespace nacre::app
