// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/remesh_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

#include "app/files.h"
#include "app/goal.h"
#include "app/remesh_stage.h"
#include "app/report.h"
#include "io/io.h"
#include "wavelet/wavelet.h"

namespace nacre::bench {
namespace {

namespace fs = std::filesystem;

std::vector<char> read_all(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Of all sources that a normal mesh depends on, so that a changed remesher is noticed.
std::uint64_t hash_of_remesher() {
  std::vector<fs::path> files;
  for (const char* folder : {"base", "wavelet", "remesh"})
    for (const auto& entry : fs::directory_iterator(fs::path(NACRE_SOURCE_DIR) / folder))
      if (entry.path().extension() == ".cpp" || entry.path().extension() == ".h")
        files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::uint64_t state = hash_bytes(nullptr, 0);
  for (const fs::path& file : files) {
    const std::vector<char> bytes = read_all(file);
    state = hash_bytes(bytes.data(), bytes.size(), state);
  }
  return state;
}

struct Head {
  std::array<char, 8> magic = {'n', 'c', 'r', 'm', 'e', 's', 'h', '1'};
  std::uint64_t remesher = 0, triangles = 0, positions = 0;
  std::uint32_t base_vertices = 0;
  std::int32_t levels = 0;
  std::array<double, 3> origin{};
};

void save(const fs::path& file, const SemiRegularMesh& mesh, std::uint64_t remesher) {
  fs::create_directories(file.parent_path());
  Head head;
  head.remesher = remesher;
  head.triangles = mesh.base_triangles.size();
  head.positions = mesh.positions.size();
  head.base_vertices = mesh.base_vertex_count;
  head.levels = mesh.level_count;
  for (std::size_t k = 0; k < 3; ++k) head.origin[k] = mesh.origin[static_cast<int>(k)];
  const fs::path part = file.string() + ".part";
  {
    std::ofstream out(part, std::ios::binary);
    const auto write = [&](const void* data, std::size_t size) {
      out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    };
    write(&head, sizeof head);
    write(mesh.base_triangles.data(), mesh.base_triangles.size() * sizeof(Triangle));
    write(mesh.positions.data(), mesh.positions.size() * sizeof(Vec3));
    if (!out.flush()) return;
  }
  fs::rename(part, file);
}

/// Nothing if there is none, or one of another remesher.
std::optional<SemiRegularMesh> load(const fs::path& file, std::optional<std::uint64_t> remesher) {
  const std::vector<char> bytes = read_all(file);
  Head head;
  if (bytes.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, bytes.data(), sizeof head);
  const std::size_t size =
      sizeof head + head.triangles * sizeof(Triangle) + head.positions * sizeof(Vec3);
  if (head.magic != Head{}.magic || bytes.size() != size) return std::nullopt;
  if (remesher && head.remesher != *remesher) return std::nullopt;
  SemiRegularMesh mesh;
  mesh.base_triangles.resize(head.triangles);
  mesh.positions.resize(head.positions);
  mesh.base_vertex_count = head.base_vertices;
  mesh.level_count = head.levels;
  mesh.origin = Vec3(head.origin[0], head.origin[1], head.origin[2]);
  const char* at = bytes.data() + sizeof head;
  std::copy_n(at, head.triangles * sizeof(Triangle),
              reinterpret_cast<char*>(mesh.base_triangles.data()));
  at += head.triangles * sizeof(Triangle);
  std::copy_n(at, head.positions * sizeof(Vec3), reinterpret_cast<char*>(mesh.positions.data()));
  return mesh;
}

/// Remeshes, or finds what was made with options of the same name.
Result<SemiRegularMesh> remeshed(const PreparedScan& scan, const CacheOptions& cache,
                                 remesh::Options options, const std::string& name) {
  const fs::path kept =
      cache.folder / fmt::format("{}-{:016x}-{}.mesh", scan.name, scan.content, name);
  const std::uint64_t remesher = hash_of_remesher();
  if (!cache.folder.empty()) {
    auto mesh = load(kept, cache.keep_old_remesh ? std::nullopt : std::optional(remesher));
    if (mesh) return std::move(*mesh);
  }
  options.predict = wavelet::predict_at_need;
  auto out = remesh::remesh(scan.scan, options);
  if (!out) return out.error();
  if (!cache.folder.empty()) save(kept, out->mesh, remesher);
  return std::move(out->mesh);
}

}  // namespace

std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t state) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) state = (state ^ bytes[i]) * 0x100000001B3ull;
  return state;
}

Result<PreparedScan> prepare_scan(const std::string& file, const CacheOptions& options) {
  auto read = io::read_scan(file);
  if (!read) return read.error();
  auto surface = metric::Surface::build(read->scan);
  if (!surface) return surface.error();
  const std::size_t input_vertices = app::input_facts(file, *read).goal_vertices;
  const std::vector<char> bytes = read_all(file);
  PreparedScan prepared{fs::path(file).stem().string(),
                        hash_bytes(bytes.data(), bytes.size()),
                        std::move(read->scan),
                        input_vertices,
                        std::move(*surface),
                        {}};
  remesh::Options remesh_options;
  remesh_options.base_vertices = options.base_vertices;
  remesh_options.levels = options.levels;
  auto mesh = remeshed(prepared, options, remesh_options,
                       fmt::format("b{}-j{}", options.base_vertices, options.levels));
  if (!mesh) return mesh.error();
  prepared.mesh = std::move(*mesh);
  return prepared;
}

Result<SemiRegularMesh> mesh_for_size(const PreparedScan& scan, const CacheOptions& options,
                                      std::size_t bytes) {
  app::RemeshSettings settings;
  settings.base_vertices = options.base_vertices;
  settings.levels = options.levels;
  settings = app::for_size(settings, static_cast<double>(bytes), scan.input_vertices);
  return remeshed(scan, options, app::remesh_options(settings),
                  fmt::format("b{}-j{}-l{}-m{}-t{}", options.base_vertices, options.levels,
                              settings.least_base_vertices, settings.most_base_vertices,
                              settings.least_triangles));
}

Result<metric::Comparison> distance_to_scan(const PreparedScan& scan, const SemiRegularMesh& mesh,
                                            std::size_t samples) {
  const auto triangles = app::to_triangles(mesh);
  if (!triangles) return triangles.error();
  return metric::compare(scan.scan, scan.surface, *triangles, {.samples = samples});
}

}  // namespace nacre::bench
