// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/choose_base.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "base/parallel.h"
#include "remesh/clean_steps.h"
#include "remesh/parameterise.h"
#include "remesh/relax.h"
#include "remesh/simplify.h"

namespace nacre::remesh {
namespace {

struct Setting {
  double shape_weight, normal_agreement;
};
/// In the order in which they are tried.
constexpr std::array<Setting, 4> kSettings = {{{0.3, 0.4}, {1.0, 0.2}, {0.1, 0.2}, {1.0, 0.4}}};

/// Trials go this far, or as far as gives them this many triangles for each one of the scan.
constexpr int kTrialLevels = 4;
constexpr std::size_t kTrialTriangles = 3;
constexpr std::size_t kTrialSamples = 20'000;
/// A scan vertex this many times the root mean square away is missed: a tip, mostly.
constexpr double kFar = 12;
/// Every triangle that is folded, or turned over in the domain, makes a trial this much worse.
constexpr double kFoldPenalty = 0.05;
/// Unless all has been done about folds.
constexpr double kMendedFoldPenalty = 0.01;

/// So many of the best trials are repaired, in so many rounds.
constexpr std::size_t kRepaired = 2;
constexpr int kRepairRounds = 3;
/// With so many base vertices no single one spoils the mesh: half as many settings are tried, the
/// best one is repaired once.
constexpr int kManyVertices = 2000;

/// Trials are made on a scan of about this many vertices, or so many for each base vertex.
constexpr std::size_t kProxyVertices = 10'000, kProxyPerBase = 20;
/// With fewer for each base vertex than this, they are made again on a larger proxy.
constexpr std::size_t kLeastPerBase = 5;
/// The map that comes back through the proxy has kinks where its triangles meet.
constexpr int kFinalRounds = 2;

/// If more than this share of the squared error on the scan itself is at places that are missed, so
/// many times the vertices are tried.
constexpr double kMuchMissed = 0.25, kMoreForMissed = 1.5;
/// Where the error of missed places alone, by area, is more than this share of the scan's extent
/// (84 dB), trials follow with the vertices there so much dearer.
constexpr double kMuchByMissed = 6e-5;
constexpr std::array<double, 2> kMissedDearer = {16, 64};
/// With more folds than this on the scan itself, the next best trials are looked at there as well.
constexpr double kFewFolds = 50;
/// What one more level leaves of the squared error, where nothing is missed.
constexpr double kLeftByLevel = 0.16;
/// Larger scans are not looked at again: it would take as long as the final piercing.
constexpr std::size_t kMostLookedAt = 200'000;

/// How much dearer one round makes the vertices where a trial is unhealthy.
constexpr double kDearer = 8;

struct TrialOptions {
  SimplifyOptions simplify;
  int levels = 0;  // of the final mesh; 0: not known
  int useful = 0;  // see BaseSize
};

/// A vertex of the scan that the trial mesh does not come near.
struct Missed {
  std::uint32_t vertex;
  double distance;
};

/// A map onto a base mesh, and what comes of it at a coarse level.
struct Trial {
  TrialOptions options;
  Parameterisation map;  // without triangles if none could be made
  std::vector<std::uint32_t>
      unhealthy;  // per base triangle: not 0 where it folds or misses the scan
  double figure = std::numeric_limits<double>::infinity();
  double folds = 0;            ///< and triangles turned over
  double far_share = 0;        ///< of the squared error, at places that are missed
  std::vector<Missed> missed;  ///< those places
  std::vector<Health> health;  // per base triangle

  [[nodiscard]] bool made() const { return !map.base.triangles.empty(); }
  /// The figure a level further on: what is missed stays so.
  [[nodiscard]] double outlook() const {
    return figure * std::sqrt(far_share + kLeftByLevel * (1 - far_share));
  }
};

/// A smaller scan that stands for the given one in trials, and how to come back.
struct Proxy {
  Scan scan;
  Parameterisation map;  // of the given scan onto it
};

Result<Proxy> make_proxy(const Scan& scan, std::size_t vertices, const Importance& importance,
                         const RunContext& context) {
  SimplifyOptions options;
  options.base_vertices = static_cast<int>(vertices);
  options.chords = false;
  auto map = simplify(scan, options, importance, context);
  if (!map) return map.error();
  Proxy proxy;
  proxy.scan.triangles = map->base.triangles;
  for (const std::uint32_t v : map->base.scan_vertex)
    proxy.scan.positions.push_back(scan.positions[v]);
  proxy.map = std::move(*map);
  return proxy;
}

/// The composition: given scan → proxy → base.
Parameterisation through(const Proxy& proxy, const Parameterisation& map) {
  Parameterisation out;
  out.base = map.base;
  for (std::uint32_t& v : out.base.scan_vertex) v = proxy.map.base.scan_vertex[v];
  out.point.resize(proxy.map.point.size());
  const SurfaceMap surface_map(proxy.scan, map);
  parallel_for_each_index(out.point.size(), [&](std::size_t v) {
    const DomainPoint& p = proxy.map.point[v];
    out.point[v] = surface_map.to_domain({p.face, p.weight});
  });
  return out;
}

std::size_t sample_step(std::size_t count) {
  return std::max<std::size_t>(1, count / kTrialSamples);
}

/// Of every so-manyth of `count` things.
template <class DistanceOf>
Distances distances(std::size_t count, const DistanceOf& distance_of) {
  Distances d;
  d.step = sample_step(count);
  d.at.resize(count / d.step);
  parallel_for_each_index(d.at.size(), [&](std::size_t i) { d.at[i] = distance_of(i * d.step); });
  return d;
}

std::vector<Triangle> finest_triangles(const SemiRegularMesh& mesh) {
  const auto topology =
      Topology::build_for_decoding(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  std::vector<Triangle> triangles(topology->triangle_count(mesh.level_count));
  for (std::size_t i = 0; i < triangles.size(); ++i)
    triangles[i] = topology->triangle(mesh.level_count, i);
  return triangles;
}

/// Vertices whose place is no number move to the origin; 1 for base triangles that have such.
std::vector<char> mend_broken(Scan& fine, std::size_t base_triangles) {
  std::vector<char> broken(base_triangles, 0);
  const std::size_t children = fine.triangles.size() / std::max<std::size_t>(base_triangles, 1);
  bool any = false;
  for (const Vec3& p : fine.positions) any |= !p.allFinite();
  if (!any) return broken;
  for (std::size_t t = 0; t < fine.triangles.size(); ++t)
    for (const std::uint32_t v : fine.triangles[t])
      if (!fine.positions[v].allFinite()) broken[t / children] = 1;
  for (Vec3& p : fine.positions)
    if (!p.allFinite()) p = Vec3::Zero();
  return broken;
}

int trial_levels(const Scan& scan, const BaseMesh& base, int most) {
  int levels = most > 0 ? std::min(most, kTrialLevels) : kTrialLevels;
  while (levels > 1 &&
         (base.triangles.size() << (2 * levels)) > kTrialTriangles * scan.triangles.size())
    --levels;
  return levels;
}

/// Of the triangles around each vertex, all together.
std::vector<double> vertex_areas(const Scan& scan) {
  std::vector<double> area(scan.positions.size(), 0);
  const auto& p = scan.positions;
  for (const Triangle& t : scan.triangles) {
    const double twice = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm();
    for (const std::uint32_t v : t) area[v] += twice / 2;
  }
  return area;
}

/// Closer: a level more, measured by area, and with what piercing does about folds in the end.
enum class Look : std::uint8_t { kUsual, kCloser };

/// Pierces the trial's map and looks.
void judge(const Scan& scan, const LineTree& tree, std::size_t turned,
           const LevelPredictor& predict, const RunContext& context, Trial& trial,
           Look look = Look::kUsual) {
  PierceOptions pierce_options;
  // Moving older vertices takes time that is better spent on the scan itself.
  pierce_options.move_older = look == Look::kCloser;
  pierce_options.levels = trial_levels(scan, trial.map.base, trial.options.levels);
  if (look == Look::kCloser && pierce_options.levels != trial.options.levels)
    ++pierce_options.levels;
  auto pierced =
      pierce(SurfaceMap(scan, trial.map), trial.map, tree, predict, pierce_options, context);
  trial.unhealthy.assign(trial.map.base.triangles.size(), 0);
  trial.missed.clear();
  if (!pierced) return;
  SemiRegularMesh& mesh = pierced->mesh;
  Scan fine{{}, finest_triangles(mesh), mesh.origin};
  fine.positions = std::move(mesh.positions);
  const std::vector<char> broken = mend_broken(fine, trial.map.base.triangles.size());
  const MeshTree fine_tree(fine, mesh.level_count);
  const Distances missed = distances(
      scan.positions.size(), [&](std::size_t v) { return fine_tree.distance(scan.positions[v]); });
  // The triangles' centroids, unlike the vertices, need not lie on the scan.
  const Distances strayed = distances(fine.triangles.size(), [&](std::size_t i) {
    const Triangle& t = fine.triangles[i];
    const Vec3 p = (fine.positions[t[0]] + fine.positions[t[1]] + fine.positions[t[2]]) / 3;
    return (position_of(tree.nearest(p), scan.triangles, scan.positions) - p).norm();
  });
  trial.health = health_of(
      {scan, tree, trial.map, fine, fine_tree, mesh.level_count, pierced->folds}, missed, strayed);
  for (std::size_t f = 0; f < broken.size(); ++f) trial.health[f].is_finite = broken[f] == 0;
  trial.unhealthy.assign(pierced->folds.begin(), pierced->folds.end());
  // Pits are deep, with few vertices for their area.
  const std::vector<double> weight =
      look == Look::kCloser ? vertex_areas(scan) : std::vector<double>(scan.positions.size(), 1.0);
  const double far = kFar * missed.rms();
  double far_error = 0, all_error = 0, all_weight = 0;
  for (std::size_t i = 0; i < missed.at.size(); ++i) {
    const double w = weight[i * missed.step];
    all_weight += w;
    all_error += w * missed.at[i] * missed.at[i];
    if (!(missed.at[i] > far)) continue;
    far_error += w * missed.at[i] * missed.at[i];
    trial.missed.push_back({static_cast<std::uint32_t>(i * missed.step), missed.at[i]});
    trial.unhealthy[trial.map.point[i * missed.step].face] = 1;
  }
  trial.far_share = all_error > 0 ? far_error / all_error : 0;
  trial.folds = static_cast<double>(turned);
  for (const BandReport& band : pierced->bands)
    trial.folds += static_cast<double>(band.folded_triangles);
  const double missed_rms = std::sqrt(all_error / std::max(all_weight, 1e-300));
  trial.figure = std::max(missed_rms, strayed.rms()) *
                 std::pow(static_cast<double>(mesh.base_vertex_count), kErrorPerSize) *
                 (1 + (look == Look::kCloser ? kMendedFoldPenalty : kFoldPenalty) * trial.folds);
}

Trial attempt(const Scan& scan, const LineTree& tree, const TrialOptions& options,
              const Importance& importance, const LevelPredictor& predict,
              const RunContext& context) {
  Trial trial;
  trial.options = options;
  auto map = simplify(scan, options.simplify, importance, context);
  if (!map) return trial;
  const std::size_t vertices = map->base.scan_vertex.size();
  if (options.useful > 0 && vertices > static_cast<std::size_t>(options.useful)) return trial;
  parameterise(scan, *map, context);
  const std::size_t turned = relax(scan, *map, {}, context);
  trial.map = std::move(*map);
  judge(scan, tree, turned, predict, context, trial);
  return trial;
}

/// Makes vertices dear under every unhealthy base triangle. False if there is none.
bool mark_unhealthy(const Trial& trial, Importance& importance) {
  bool any = false;
  for (std::size_t v = 0; v < importance.size(); ++v) {
    if (trial.unhealthy[trial.map.point[v].face] == 0) continue;
    importance[v] *= kDearer;
    any = true;
  }
  return any;
}

/// Asks for more vertices where the trial is unhealthy, again and again, and keeps the best
/// outcome.
void repair(const Scan& scan, const LineTree& tree, const LevelPredictor& predict, int rounds,
            const RunContext& context, Trial& best) {
  Importance importance(scan.positions.size(), 1.0);
  std::optional<Trial> latest;
  for (int round = 0; round < rounds && !context.cancelled(); ++round) {
    if (!mark_unhealthy(latest ? *latest : best, importance)) return;
    latest = attempt(scan, tree, best.options, importance, predict, context);
    if (!latest->made()) return;
    if (latest->figure < best.figure) best = *latest;
  }
}

/// Best first; at least one.
Result<std::vector<Trial>> make_trials(const Scan& scan, const LineTree& tree, const BaseSize& size,
                                       int levels, const LevelPredictor& predict,
                                       const RunContext& context) {
  const bool few = size.few_trials || std::max(size.vertices, size.least) >= kManyVertices;
  std::vector<Trial> trials(size.one_trial ? 1 : few ? kSettings.size() / 2 : kSettings.size());
  // Progress is told by one of them: they run side by side.
  RunContext quiet = context;
  quiet.progress = nullptr;
  parallel_for_each_index(
      trials.size(),
      [&](std::size_t i) {
        TrialOptions options;
        options.levels = levels;
        options.useful = size.useful;
        options.simplify.base_vertices = size.vertices;
        options.simplify.least_vertices = size.least;
        options.simplify.most_vertices = size.most;
        options.simplify.shape_weight = kSettings[i].shape_weight;
        options.simplify.normal_agreement = kSettings[i].normal_agreement;
        trials[i] = attempt(scan, tree, options, {}, predict, i == 0 ? context : quiet);
      },
      1);
  const auto better = [](const Trial& a, const Trial& b) { return a.figure < b.figure; };
  std::stable_sort(trials.begin(), trials.end(), better);
  parallel_for_each_index(
      few || size.one_trial ? 1 : kRepaired,
      [&](std::size_t i) {
        if (trials[i].made() && !size.one_trial)
          repair(scan, tree, predict, kRepairRounds, quiet, trials[i]);
      },
      1);
  if (context.cancelled()) return Error{ErrorCode::kCancelled, "interrupted", 0};
  std::erase_if(trials, [](const Trial& trial) { return !trial.made(); });
  if (trials.empty()) return Error{ErrorCode::kNoConvergence, "no base mesh could be made", 0};
  std::stable_sort(trials.begin(), trials.end(), better);
  return trials;
}

/// The trial with its map carried to the scan itself, and judged there if that is asked for.
Trial bring_back(const Scan& scan, const LineTree& tree, const Proxy& proxy, Trial trial,
                 bool is_judged, const LevelPredictor& predict, const RunContext& context) {
  trial.map = through(proxy, trial.map);
  RelaxOptions relax_options;
  relax_options.rounds = kFinalRounds;
  const std::size_t turned = relax(scan, trial.map, relax_options, context);
  trial.far_share = trial.folds = 0;
  if (is_judged) judge(scan, tree, turned, predict, context, trial);
  return trial;
}

/// Whether what the trial mesh leaves out bounds the whole mesh, whatever the rest is like.
bool misses_much(const Scan& scan, const Trial& trial) {
  if (trial.missed.empty()) return false;
  Box box;
  for (const Vec3& p : scan.positions) box.add(p);
  const std::vector<double> area = vertex_areas(scan);
  const double all = std::accumulate(area.begin(), area.end(), 0.0);
  double sum = 0;
  for (const Missed& missed : trial.missed)
    sum += area[missed.vertex] * missed.distance * missed.distance;
  sum *= static_cast<double>(sample_step(scan.positions.size()));
  return std::sqrt(sum / all) > kMuchByMissed * box.extent();
}

/// As the trial is told from others, with a level more and its folds mended.
double closer_outlook(const Scan& scan, const LineTree& tree, const LevelPredictor& predict,
                      const RunContext& context, Trial trial) {
  judge(scan, tree, 0, predict, context, trial, Look::kCloser);
  return trial.outlook();
}

/// The trial again, with as many base vertices and those so much dearer that are missed now.
Trial placed_again(const Scan& scan, const LineTree& tree, std::size_t proxy_vertices,
                   double dearer, const LevelPredictor& predict, const RunContext& context,
                   const Trial& trial) {
  Importance importance(scan.positions.size(), 1.0), on_proxy;
  for (const Missed& missed : trial.missed) importance[missed.vertex] = dearer;
  const auto proxy = make_proxy(scan, proxy_vertices, importance, context);
  if (!proxy) return {};
  for (const std::uint32_t v : proxy->map.base.scan_vertex) on_proxy.push_back(importance[v]);
  TrialOptions options = trial.options;
  options.simplify.base_vertices = static_cast<int>(trial.map.base.scan_vertex.size());
  Trial again = attempt(proxy->scan, LineTree(proxy->scan), options, on_proxy, predict, context);
  if (!again.made()) return {};
  return bring_back(scan, tree, *proxy, std::move(again), true, predict, context);
}

/// Where the trial misses something large, its vertices are placed anew, in several ways, and the
/// best outcome stays.
void place_at_missed(const Scan& scan, const LineTree& tree, std::size_t proxy_vertices,
                     const LevelPredictor& predict, const RunContext& context, Trial& best) {
  // What folds all over misses the scan for other reasons.
  if (best.folds > kFewFolds || !misses_much(scan, best)) return;
  RunContext quiet = context;
  quiet.progress = nullptr;
  std::array<Trial, kMissedDearer.size() + 1> trials;
  std::array<double, kMissedDearer.size() + 1> outlook;
  parallel_for_each_index(
      trials.size(),
      [&](std::size_t i) {
        outlook[i] = std::numeric_limits<double>::infinity();
        trials[i] = i == 0 ? best
                           : placed_again(scan, tree, proxy_vertices, kMissedDearer[i - 1], predict,
                                          quiet, best);
        if (trials[i].made()) outlook[i] = closer_outlook(scan, tree, predict, quiet, trials[i]);
      },
      1);
  const auto least = std::min_element(outlook.begin(), outlook.end()) - outlook.begin();
  best = std::move(trials[static_cast<std::size_t>(least)]);
}

/// On a proxy of about so many vertices if the scan has clearly more; then judged on the scan
/// itself, where that decides about anything. What is healthy on the proxy may fold there. Makes
/// the scan's tree if there is none yet.
Result<Trial> choose_on_proxy(const Scan& scan, std::shared_ptr<const LineTree>& tree_of_scan,
                              std::size_t proxy_vertices, const BaseSize& size, int levels,
                              const LevelPredictor& predict, const RunContext& context) {
  const auto make_tree = [&] {
    if (!tree_of_scan) tree_of_scan = std::make_shared<const LineTree>(scan);
  };
  if (scan.positions.size() <= proxy_vertices * 5 / 4) {
    make_tree();
    auto trials = make_trials(scan, *tree_of_scan, size, levels, predict, context);
    if (!trials) return trials.error();
    return std::move(trials->front());
  }
  Result<Proxy> proxy = Proxy{};
  in_parallel([&] { proxy = make_proxy(scan, proxy_vertices, {}, context); }, make_tree);
  if (!proxy) return proxy.error();
  const LineTree& tree = *tree_of_scan;
  const LineTree proxy_tree(proxy->scan);
  auto trials = make_trials(proxy->scan, proxy_tree, size, levels, predict, context);
  if (!trials) return trials.error();
  const bool is_judged = size.vertices == 0 && scan.positions.size() <= kMostLookedAt;
  const auto brought_back = [&](const Trial& trial) {
    return bring_back(scan, tree, *proxy, trial, is_judged, predict, context);
  };
  Trial best = brought_back(trials->front());
  if (best.folds <= kFewFolds) return best;
  if (size.few_trials) {
    BaseSize all = size;
    all.few_trials = false;
    trials = make_trials(proxy->scan, proxy_tree, all, levels, predict, context);
    if (!trials) return trials.error();
  }
  for (std::size_t i = size.few_trials ? 0 : 1; i < trials->size() && best.folds > kFewFolds; ++i) {
    Trial next = brought_back((*trials)[i]);
    if (next.outlook() < best.outlook()) best = std::move(next);
  }
  return best;
}

}  // namespace

Result<BaseChoice> choose_base(const Scan& scan, const BaseSize& size, int levels,
                               const LevelPredictor& predict, const RunContext& context) {
  std::shared_ptr<const LineTree> tree;
  const auto choice = [&](Trial& trial) {
    return BaseChoice{std::move(trial.map), std::move(trial.health), tree};
  };
  std::size_t proxy_vertices =
      std::max(kProxyVertices,
               kProxyPerBase * static_cast<std::size_t>(std::max(size.vertices, size.least)));
  auto best = choose_on_proxy(scan, tree, proxy_vertices, size, levels, predict, context);
  if (!best) return best.error();
  if (kLeastPerBase * best->map.base.scan_vertex.size() > proxy_vertices) {
    // Many pieces or handles ask for more base vertices than the proxy can tell apart.
    proxy_vertices = kProxyPerBase * best->map.base.scan_vertex.size();
    best = choose_on_proxy(scan, tree, proxy_vertices, size, levels, predict, context);
    if (!best) return best.error();
  }
  // What the proxy does not have, such as a narrow pit, only the scan itself can tell.
  if (size.vertices == 0 && scan.positions.size() > proxy_vertices * 5 / 4)
    place_at_missed(scan, *tree, proxy_vertices, predict, context, *best);
  const auto now = static_cast<double>(best->map.base.scan_vertex.size());
  const int more = static_cast<int>(kMoreForMissed * now);
  if (size.vertices > 0 || best->far_share < kMuchMissed || (size.most > 0 && more > size.most))
    return choice(*best);
  BaseSize larger = size;
  larger.least = larger.most = more;
  auto other = choose_on_proxy(scan, tree, proxy_vertices, larger, levels, predict, context);
  if (!other && other.error().code == ErrorCode::kCancelled) return other.error();
  return choice(other && other->figure < best->figure ? *other : *best);
}

}  // namespace nacre::remesh
