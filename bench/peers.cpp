// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: the sweep is measured twice. Once with few samples, to find out which points no
// smaller one beats; these again with all samples.
#include "bench/peers.h"

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "base/parallel.h"
#include "bench/support.h"
#include "io/io.h"
#include "io/write.h"
#include "remesh/cgal_mesh.h"

namespace nacre::bench {
namespace {

namespace fs = std::filesystem;
namespace pmp = CGAL::Polygon_mesh_processing;
using Point = CGAL::Simple_cartesian<double>::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

constexpr std::size_t kFewSamples = 100'000;
constexpr double kSizeRatio = 1.18;   // between simplified meshes
constexpr double kFrontRatio = 1.06;  // between points that are kept, at least
constexpr int kLeastBits = 5, kMostBits = 16;
constexpr double kTimeout = 300;

bool on_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  return false;
}

Result<Mesh> to_cgal(const Scan& scan) {
  std::vector<Point> points;
  for (const Vec3& p : scan.positions) points.emplace_back(p[0], p[1], p[2]);
  std::vector<std::vector<std::size_t>> faces;
  for (const Triangle& t : scan.triangles) faces.push_back({t[0], t[1], t[2]});
  try {
    pmp::repair_polygon_soup(points, faces);
    pmp::orient_polygon_soup(points, faces);
    Mesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
    return mesh;
  } catch (const std::exception& e) {
    return Error{ErrorCode::kBadInput, std::string("CGAL makes no mesh of the scan: ") + e.what()};
  }
}

/// A mesh to be coded, and how far it is from the scan already.
struct Candidate {
  Scan mesh;
  bool is_simplified = true;
  double rms = 0;
};

Result<metric::Comparison> distance(const PreparedScan& scan, const Scan& mesh,
                                    std::size_t samples) {
  Scan placed = mesh;
  placed.origin += scan.scan.origin;
  return metric::compare(scan.scan, scan.surface, placed, {.samples = samples});
}

/// Through Draco's command line and back: bytes, and what comes out.
Result<std::pair<std::size_t, Scan>> through_draco(const fs::path& folder, const fs::path& input,
                                                   int bits) {
  const std::string coded = (folder / fmt::format("{}-{}.drc", input.stem().string(), bits));
  const std::string back = coded + ".ply";
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"draco_encoder", "-i", input, "-o", coded, "-qp",
                                 std::to_string(bits), "-cl", "10"},
        {"draco_decoder", "-i", coded, "-o", back}}) {
    const ChildRun run = run_child(command, kTimeout);
    if (!run.ok()) return Error{ErrorCode::kBadInput, command[0] + ": " + run.outcome()};
  }
  const std::size_t bytes = fs::file_size(coded);
  auto read = io::read_scan(back);
  fs::remove(coded);
  fs::remove(back);
  if (!read) return read.error();
  return std::pair(bytes, std::move(read->scan));
}

double extent_of(const Scan& scan) {
  Vec3 low = scan.positions[0], high = low;
  for (const Vec3& p : scan.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).maxCoeff();
}

/// Precisions about the one whose rounding errs as much as the simplification.
std::vector<int> bits_to_try(const Candidate& candidate) {
  std::vector<int> bits;
  int first = kLeastBits, last = 12;
  if (candidate.is_simplified) {
    const double rounding = extent_of(candidate.mesh) / std::sqrt(12.0);
    const auto equal = static_cast<int>(std::floor(std::log2(rounding / candidate.rms)));
    first = equal - 1;
    last = equal + 2;
  }
  for (int b = std::max(first, kLeastBits); b <= std::min(last, kMostBits); ++b) bits.push_back(b);
  return bits;
}

class Sweep {
 public:
  Sweep(const PreparedScan& scan, const PeerOptions& options) : scan_(scan), options_(options) {}

  Result<std::vector<PeerPoint>> run() {
    auto mesh = to_cgal(scan_.scan);
    if (!mesh) return mesh.error();
    candidates_.push_back({scan_.scan, false, 0});
    candidates_[0].mesh.origin = Vec3::Zero();
    // A vertex takes 12 to 30 bits at these precisions.
    double vertices = options_.max_bytes * 8 / 10;
    const double least = options_.min_bytes * 8 / 40;
    for (; vertices >= least; vertices /= kSizeRatio) {
      if (vertices > 0.9 * static_cast<double>(mesh->number_of_vertices())) continue;
      namespace sms = CGAL::Surface_mesh_simplification;
      sms::edge_collapse(*mesh,
                         sms::Count_stop_predicate<Mesh>(static_cast<std::size_t>(3 * vertices)));
      candidates_.push_back({remesh::scan_of(*mesh), true, 0});
    }
    std::vector<std::vector<PeerPoint>> found(candidates_.size());
    parallel_for_each_index(
        found.size(), [&](std::size_t i) { found[i] = run_candidate(i); }, 1);
    for (const auto& points : found) points_.insert(points_.end(), points.begin(), points.end());
    return measure_front();
  }

 private:
  [[nodiscard]] fs::path input_of(std::size_t i) const {
    return folder_.path() / fmt::format("{}.ply", i);
  }

  std::vector<PeerPoint> run_candidate(std::size_t i) {
    Candidate& candidate = candidates_[i];
    TriangleMesh mesh;
    mesh.positions = candidate.mesh.positions;
    mesh.triangles = candidate.mesh.triangles;
    const auto bytes = io::serialize_mesh(mesh, io::MeshFormat::kPly);
    if (!bytes || !io::write_file(input_of(i), *bytes, true)) return {};
    if (candidate.is_simplified) {
      const auto d = distance(scan_, candidate.mesh, kFewSamples);
      if (!d) return {};
      candidate.rms = std::max({d->a_to_b.rms, d->b_to_a.rms, 1e-9 * d->bbox_diagonal});
    }
    std::vector<PeerPoint> points;
    for (const int bits : bits_to_try(candidate)) {
      const auto point = run_draco(i, bits, kFewSamples);
      if (point) points.push_back(*point);
      // More bits are more bytes.
      if (!point || point->point.bytes > 1.3 * options_.max_bytes) break;
    }
    return points;
  }

  std::optional<PeerPoint> run_draco(std::size_t i, int bits, std::size_t samples) const {
    const auto coded = through_draco(folder_.path(), input_of(i), bits);
    if (!coded) return std::nullopt;
    PeerPoint out{candidates_[i].mesh.triangles.size(), bits, candidates_[i].is_simplified, {}};
    out.point.bytes = static_cast<double>(coded->first);
    if (out.point.bytes > 1.3 * options_.max_bytes) return out;  // of no use: not measured
    const auto d = distance(scan_, coded->second, samples);
    if (!d) return std::nullopt;
    out.point = rate_point(coded->first, *d);
    return out;
  }

  /// Points that have more dB than all smaller ones, a few percent apart, with all samples.
  Result<std::vector<PeerPoint>> measure_front() const {
    std::vector<RatePoint> all;
    for (const PeerPoint& p : points_) all.push_back(p.point);
    std::vector<PeerPoint> front;
    double group_begin = 0;
    for (const RatePoint& best : rising(std::move(all))) {
      const auto at = std::find_if(points_.begin(), points_.end(), [&](const PeerPoint& p) {
        return p.point.bytes == best.bytes && p.point.psnr_db == best.psnr_db;
      });
      if (best.bytes > 1.3 * options_.max_bytes) break;
      // Of points closer together than that, the best.
      if (best.bytes <= kFrontRatio * group_begin) {
        front.back() = *at;
        continue;
      }
      front.push_back(*at);
      group_begin = best.bytes;
    }
    parallel_for_each_index(
        front.size(),
        [&](std::size_t k) {
          for (std::size_t i = 0; i < candidates_.size(); ++i) {
            if (candidates_[i].mesh.triangles.size() != front[k].triangles) continue;
            const auto point = run_draco(i, front[k].position_bits, options_.samples);
            if (point) front[k] = *point;
            break;
          }
        },
        1);
    return front;
  }

  const PreparedScan& scan_;
  const PeerOptions& options_;
  TemporaryFolder folder_;
  std::vector<Candidate> candidates_;
  std::vector<PeerPoint> points_;
};

fs::path cache_file(const PreparedScan& scan, const PeerOptions& options) {
  return options.folder / fmt::format("{}-{:016x}-{:.0f}-{:.0f}-{}.front", scan.name, scan.content,
                                      options.min_bytes, options.max_bytes, options.samples);
}

std::vector<PeerPoint> load(const fs::path& file) {
  std::ifstream in(file);
  std::vector<PeerPoint> points;
  PeerPoint p;
  RatePoint& r = p.point;
  while (in >> p.triangles >> p.position_bits >> p.is_simplified >> r.bytes >> r.psnr_db >>
         r.psnr_of_maximum_db >> r.rms_a_to_b >> r.rms_b_to_a >> r.maximum_a_to_b >>
         r.maximum_b_to_a)
    points.push_back(p);
  return points;
}

void save(const fs::path& file, const std::vector<PeerPoint>& points) {
  fs::create_directories(file.parent_path());
  const fs::path part = file.string() + ".part";
  {
    std::ofstream out(part);
    for (const PeerPoint& p : points) {
      const RatePoint& r = p.point;
      out << fmt::format("{} {} {} {} {} {} {} {} {} {}\n", p.triangles, p.position_bits,
                         p.is_simplified ? 1 : 0, r.bytes, r.psnr_db, r.psnr_of_maximum_db,
                         r.rms_a_to_b, r.rms_b_to_a, r.maximum_a_to_b, r.maximum_b_to_a);
    }
    if (!out.flush()) return;
  }
  fs::rename(part, file);
}

}  // namespace

bool has_draco() { return on_path("draco_encoder") && on_path("draco_decoder"); }

Result<std::vector<PeerPoint>> simplify_and_draco(const PreparedScan& scan,
                                                  const PeerOptions& options) {
  if (!options.folder.empty()) {
    auto kept = load(cache_file(scan, options));
    if (!kept.empty()) return kept;
  }
  auto points = Sweep(scan, options).run();
  if (points && !options.folder.empty()) save(cache_file(scan, options), *points);
  return points;
}

}  // namespace nacre::bench
