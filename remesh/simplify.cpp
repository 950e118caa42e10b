// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: vertices wait in a queue with the cost of their best collapse. A collapse makes
// the costs around it stale; a stale vertex is re-evaluated only when it reaches the front, which
// is where nearly all the time would go otherwise.
#include "remesh/simplify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/tips.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A flattened triangle below this share of its squared longest side counts as inverted.
constexpr double kMinFlatArea = 1e-4;
/// Shape costs are lengths to the fourth power, as area × squared distance is; this makes
/// shape_weight = 1 balance the two on curved scans of 200 base vertices.
constexpr double kShapeScale = 1e-4;
/// What tips_of() finds, and the vertices around, is so much dearer: it is to be in the base.
constexpr double kTipDearer = 1e6;

double signed_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Squared distance to a set of planes, weighted by area: p' A p + 2 b' p + c.
struct Quadric {
  std::array<double, 10> q{};

  static Quadric plane(const Vec3& normal, const Vec3& through, double weight) {
    const double d = -normal.dot(through);
    const double n[4] = {normal[0], normal[1], normal[2], d};
    Quadric out;
    int at = 0;
    for (int i = 0; i < 4; ++i)
      for (int k = i; k < 4; ++k) out.q[static_cast<std::size_t>(at++)] = weight * n[i] * n[k];
    return out;
  }
  void operator+=(const Quadric& o) {
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += o.q[i];
  }
  [[nodiscard]] double at(const Vec3& p) const {
    const double x = p[0], y = p[1], z = p[2];
    const double v = q[0] * x * x + 2 * q[1] * x * y + 2 * q[2] * x * z + 2 * q[3] * x +
                     q[4] * y * y + 2 * q[5] * y * z + 2 * q[6] * y + q[7] * z * z + 2 * q[8] * z +
                     q[9];
    return std::max(v, 0.0);
  }
};

/// A vertex's star, laid flat with the vertex at the origin (z^a, so that angles fill the circle).
struct FlatStar {
  Star star;
  std::vector<Vec2> ring;  // flat positions of star.ring
};

/// Room to work in, kept to avoid allocations in the inner loop.
struct Scratch {
  FlatStar flat;
  Star other;
  std::vector<double> angle, length;
};

struct Candidate {
  double cost = kInfinity;
  std::uint32_t target = kNone;
};

class Simplifier {
 public:
  Simplifier(const Scan& scan, const SimplifyOptions& options, const Importance& importance)
      : scan_(scan),
        options_(options),
        importance_(importance.empty() ? Importance(scan.positions.size(), 1.0) : importance),
        faces_(scan.triangles),
        neighbors_(
            side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))),
        face_of_(
            face_of_vertex(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))) {
    prepare();
  }

  Result<Parameterisation> run(const RunContext& context) {
    const bool is_count_given = options_.base_vertices > 0;
    const auto target = static_cast<std::size_t>(
        std::max(is_count_given ? options_.base_vertices : options_.least_vertices, 1));
    const double most_error = is_count_given ? kInfinity : error_limit();
    const std::size_t most =
        options_.most_vertices > 0
            ? std::max(static_cast<std::size_t>(options_.most_vertices), target)
            : std::numeric_limits<std::size_t>::max();
    const std::size_t start = alive_;
    if (alive_ > target) fill_queue();
    while (alive_ > target && (total_error_ < most_error || alive_ > most) && !queue_.empty()) {
      const Entry top = queue_.top();
      queue_.pop();
      if (top.stamp != stamp_[top.vertex]) continue;
      if (stale_[top.vertex]) {
        push(top.vertex);
        continue;
      }
      if (!collapse(top.vertex, top.target)) blocked_[top.vertex] = 1;
      if ((alive_ & 0x3FF) == 0) {
        if (context.cancelled()) return Error{ErrorCode::kCancelled, "interrupted", 0};
        context.report("base mesh",
                       static_cast<double>(start - alive_) / static_cast<double>(start - target));
      }
    }
    return finish();
  }

 private:
  struct Entry {
    double cost;
    std::uint32_t vertex, target, stamp;
    bool operator<(const Entry& o) const {
      return cost != o.cost ? cost > o.cost : vertex > o.vertex;  // cheapest on top
    }
  };

  [[nodiscard]] const Vec3& at(std::uint32_t v) const { return scan_.positions[v]; }

  void prepare() {
    const std::size_t n = scan_.positions.size();
    quadric_.assign(n, {});
    stamp_.assign(n, 0);
    stale_.assign(n, 0);
    blocked_.assign(n, 0);
    dead_vertex_.assign(n, 0);
    dead_face_.assign(faces_.size(), 0);
    point_.assign(n, {});
    next_point_.assign(n, kNone);
    first_point_.assign(faces_.size(), kNone);
    on_boundary_.assign(n, 0);
    area_vector_.assign(n, Vec3::Zero());
    face_normal_.assign(faces_.size(), Vec3::Zero());
    const std::vector<char> at_tip = vertices_at_tips(scan_);
    for (std::size_t v = 0; v < n; ++v)
      if (at_tip[v] != 0) importance_[v] *= kTipDearer;
    alive_ = n;
    for (const Vec3& p : scan_.positions) centre_ += p / static_cast<double>(n);
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      const Triangle& t = faces_[f];
      const Vec3 twice = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
      const double area = twice.norm() / 2;
      for (const std::uint32_t v : t) area_vector_[v] += twice / 6;
      face_normal_[f] = twice / 2;
      if (area > 0) add_planes(f, twice / (2 * area), area);
    }
  }

  void add_planes(std::uint32_t f, const Vec3& normal, double area) {
    const Triangle& t = faces_[f];
    const Quadric q = Quadric::plane(normal, at(t[0]) - centre_, area / 3);
    for (const std::uint32_t v : t) quadric_[v] += q;
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (neighbors_[f][k] != kNone) continue;
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const Vec3 edge = at(b) - at(a);
      const double length2 = edge.squaredNorm();
      on_boundary_[a] = on_boundary_[b] = 1;
      if (length2 == 0) continue;
      const Quadric wall =
          Quadric::plane(normal.cross(edge).normalized(), at(a) - centre_, length2);
      quadric_[a] += wall;
      quadric_[b] += wall;
    }
  }

  /// Σ area × squared distance at which the mean over the scan reaches rms_error.
  [[nodiscard]] double error_limit() const {
    Vec3 low = at(0), high = at(0);
    double area = 0;
    for (const Vec3& p : scan_.positions) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    for (const Triangle& t : scan_.triangles)
      area += (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).norm() / 2;
    const double distance = options_.rms_error * (high - low).norm();
    return area * distance * distance;
  }

  void fill_queue() {
    constexpr std::size_t kBlock = 1024;
    const std::size_t n = stamp_.size();
    std::vector<Candidate> best(n);
    parallel_for_each_index((n + kBlock - 1) / kBlock,
                            [&](std::size_t block) {
                              Scratch room;
                              for (std::size_t v = block * kBlock;
                                   v < std::min(n, (block + 1) * kBlock); ++v)
                                best[v] = best_collapse(static_cast<std::uint32_t>(v), room);
                            },
                            1);
    for (std::uint32_t v = 0; v < n; ++v) push(v, best[v]);
  }

  void push(std::uint32_t v) { push(v, best_collapse(v, scratch_)); }

  void push(std::uint32_t v, const Candidate& best) {
    stale_[v] = 0;
    blocked_[v] = 0;
    ++stamp_[v];
    if (best.target == kNone) {
      blocked_[v] = 1;
      return;
    }
    queue_.push({best.cost * importance_[v], v, best.target, stamp_[v]});
  }

  void flatten(std::uint32_t v, Scratch& room) const {
    FlatStar& flat = room.flat;
    collect_star(faces_, neighbors_, v, face_of_[v], flat.star);
    const std::size_t k = flat.star.faces.size(), n = flat.star.ring.size();
    room.angle.resize(k);
    room.length.resize(n);
    double total = 0, mean = 0;
    for (std::size_t m = 0; m < n; ++m) {
      room.length[m] = (at(flat.star.ring[m]) - at(v)).norm();
      mean += room.length[m] / static_cast<double>(n);
    }
    for (std::size_t m = 0; m < k; ++m) {
      const Vec3 a = at(flat.star.ring[m]) - at(v), b = at(flat.star.ring_at(m + 1)) - at(v);
      room.angle[m] = std::atan2(a.cross(b).norm(), a.dot(b));
      // A sliver's angle of 0 would hide its area: every wedge keeps a little room.
      room.angle[m] = std::max(room.angle[m], 1e-3);
      total += room.angle[m];
    }
    const double scale = (flat.star.boundary ? M_PI : 2 * M_PI) / total;
    flat.ring.resize(n);
    double angle = 0;
    for (std::size_t m = 0; m < n; ++m) {
      const double r =
          std::pow(std::max(room.length[m] / std::max(mean, 1e-300), 1e-3), std::min(scale, 2.0));
      flat.ring[m] = {r * std::cos(angle), r * std::sin(angle)};
      if (m < k) angle += room.angle[m] * scale;
    }
    if (flat.star.boundary) flat.ring.back()[1] = flat.ring.front()[1] = 0;
  }

  /// Faces of the star that survive the collapse onto ring vertex s: called with m of each.
  template <class Visit>
  static void for_kept_faces(const Star& star, std::size_t s, const Visit& visit) {
    const std::size_t k = star.faces.size();
    for (std::size_t m = 0; m < k; ++m) {
      if (m == s || (m + 1) % star.ring.size() == s) continue;
      visit(m);
    }
  }

  Candidate best_collapse(std::uint32_t v, Scratch& room) const {
    flatten(v, room);
    const Star& star = room.flat.star;
    const std::size_t n = star.ring.size();
    Candidate best;
    if (star.boundary && star.faces.size() < 2) return best;
    Vec3 scan_normal = Vec3::Zero();
    for (const std::uint32_t f : star.faces) scan_normal += face_normal_[f];
    const double scan_area = scan_normal.norm();
    for (std::size_t s = 0; s < n; ++s) {
      if (star.boundary && s != 0 && s + 1 != n) continue;
      const double cost = collapse_cost(room.flat, v, s, scan_normal, scan_area, best.cost);
      if (cost < best.cost && links_agree(v, s, star, room.other) &&
          (options_.chords || !makes_chord(s, star)))
        best = {cost, star.ring[s]};
    }
    return best;
  }

  double collapse_cost(const FlatStar& flat, std::uint32_t v, std::size_t s,
                       const Vec3& scan_normal, double scan_area, double bound) const {
    const Star& star = flat.star;
    const std::uint32_t j = star.ring[s];
    const Vec3& pj = at(j);
    double cost = quadric_[v].at(pj - centre_) + quadric_[j].at(pj - centre_);
    if (cost >= bound) return kInfinity;
    double shape = 0;
    bool valid = true;
    for_kept_faces(star, s, [&](std::size_t m) {
      if (!valid) return;
      const std::size_t m1 = (m + 1) % star.ring.size();
      const Vec2 &b = flat.ring[m], &c = flat.ring[m1], &a = flat.ring[s];
      const double longest =
          std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
      if (signed_area(a, b, c) <= kMinFlatArea * longest) {
        valid = false;
        return;
      }
      const Vec3 e1 = at(star.ring[m]) - pj, e2 = at(star.ring[m1]) - pj;
      const Vec3 twice = e1.cross(e2);
      const double area = twice.norm() / 2;
      const double side = std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()});
      shape += side * side;
      if (scan_area > 0 &&
          twice.dot(scan_normal) < options_.normal_agreement * 2 * area * scan_area)
        cost += side * side;  // leans away from the scan under it: allowed, but dear
    });
    if (!valid) return kInfinity;
    return cost + kShapeScale * options_.shape_weight * shape;
  }

  /// Whether the collapse joins a boundary vertex to another that is not its neighbour on the
  /// curve.
  bool makes_chord(std::size_t s, const Star& star) const {
    const std::size_t n = star.ring.size();
    if (!on_boundary_[star.ring[s]]) return false;
    for (std::size_t m = 0; m < n; ++m) {
      const bool adjacent =
          star.boundary ? m == 0 || m + 1 == n : m == s || m == (s + 1) % n || m == (s + n - 1) % n;
      if (!adjacent && on_boundary_[star.ring[m]]) return true;
    }
    return false;
  }

  /// Link condition: the collapse keeps the topology. [DeyEtAl1999]
  bool links_agree(std::uint32_t v, std::size_t s, const Star& star, Star& other) const {
    const std::uint32_t j = star.ring[s];
    const std::size_t n = star.ring.size();
    collect_star(faces_, neighbors_, j, face_of_[j], other);
    if (!star.boundary && star.faces.size() == 3 && other.faces.size() == 3 && !other.boundary)
      return false;  // a tetrahedron is as small as a closed piece gets
    const std::uint32_t before = star.boundary && s == 0 ? kNone : star.ring[(s + n - 1) % n];
    const std::uint32_t after = star.boundary && s + 1 == n ? kNone : star.ring[(s + 1) % n];
    for (const std::uint32_t w : other.ring) {
      if (w == v || w == before || w == after) continue;
      if (std::find(star.ring.begin(), star.ring.end(), w) != star.ring.end()) return false;
    }
    return true;
  }

  /// Returns false, with nothing changed, if the exact check of the new faces' normals fails.
  bool collapse(std::uint32_t v, std::uint32_t j) {
    flatten(v, scratch_);
    const Star star = scratch_.flat.star;
    const auto s = static_cast<std::size_t>(std::find(star.ring.begin(), star.ring.end(), j) -
                                            star.ring.begin());
    // The target's own star may have changed since the collapse was chosen.
    if (s == star.ring.size() || !links_agree(v, s, star, scratch_.other)) return false;
    kept_.clear();
    for_kept_faces(star, s, [&](std::size_t m) { kept_.push_back(m); });
    if (!relocate_points(v, star, s)) return false;

    for (const std::size_t m : kept_)
      faces_[star.faces[m]][corner_of(faces_[star.faces[m]], v)] = j;
    relink(star, s);
    total_error_ -= quadric_[j].at(at(j) - centre_);
    quadric_[j] += quadric_[v];
    total_error_ += quadric_[j].at(at(j) - centre_);
    importance_[j] = std::max(importance_[j], importance_[v]);
    dead_vertex_[v] = 1;
    --alive_;
    for (const std::uint32_t w : star.ring) {
      if (blocked_[w])
        push(w);
      else
        stale_[w] = 1;
    }
    return true;
  }

  /// Moves every scan vertex in the star (and `v` itself) to the new triangles.
  bool relocate_points(std::uint32_t v, const Star& star, std::size_t s) {
    moved_.clear();
    const auto locate = [&](std::uint32_t point, const Vec2& at2) {
      moved_.push_back({point, 0, {}});
      place(moved_.back(), at2, s);
    };
    locate(v, Vec2::Zero());
    for (std::size_t m = 0; m < star.faces.size(); ++m) {
      const std::uint32_t f = star.faces[m];
      const std::uint32_t c = corner_of(faces_[f], v);
      const Vec2 &q1 = scratch_.flat.ring[m], &q2 = scratch_.flat.ring[(m + 1) % star.ring.size()];
      for (std::uint32_t p = first_point_[f]; p != kNone; p = next_point_[p]) {
        const auto& w = point_[p].weight;
        locate(p, w[(c + 1) % 3] * q1 + w[(c + 2) % 3] * q2);
      }
    }
    if (!normals_agree(star, s)) return false;
    store_points(star, s);
    return true;
  }

  struct Moved {
    std::uint32_t point;
    std::size_t kept;                // index into kept_
    std::array<double, 3> weight{};  // of (target, ring m, ring m + 1)
  };

  void place(Moved& moved, const Vec2& p, std::size_t s) const {
    const Vec2& a = scratch_.flat.ring[s];
    double best = -kInfinity;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const Vec2& b = scratch_.flat.ring[kept_[i]];
      const Vec2& c = scratch_.flat.ring[(kept_[i] + 1) % scratch_.flat.ring.size()];
      const double area = signed_area(a, b, c);
      const std::array<double, 3> w = {signed_area(p, b, c) / area, signed_area(a, p, c) / area,
                                       signed_area(a, b, p) / area};
      const double least = std::min({w[0], w[1], w[2]});
      if (least > best) {
        best = least;
        moved.kept = i;
        moved.weight = w;
      }
    }
    clamp(moved.weight);
  }

  /// Weights of rounding size are 0, so that points of a boundary stay exactly on it.
  static void clamp(std::array<double, 3>& w) {
    double sum = 0;
    for (double& x : w) {
      if (x < 1e-12) x = 0;
      sum += x;
    }
    for (double& x : w) x /= sum;
  }

  /// New faces against the scan normals that fell into them.
  bool normals_agree(const Star& star, std::size_t s) const {
    sums_.assign(kept_.size(), Vec3::Zero());
    for (const Moved& moved : moved_) sums_[moved.kept] += area_vector_[moved.point];
    const Vec3& pj = at(star.ring[s]);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const Vec3 twice = (at(star.ring[kept_[i]]) - pj).cross(at(star.ring_at(kept_[i] + 1)) - pj);
      const double area = twice.norm() / 2, scan_area = sums_[i].norm();
      // Few scan vertices say little about a face's normal: then the star's own sum must do.
      if (scan_area < 0.25 * area) continue;
      if (twice.dot(sums_[i]) < options_.normal_agreement * 2 * area * scan_area) return false;
    }
    return true;
  }

  void store_points(const Star& star, std::size_t s) {
    const Vec3& pj = at(star.ring[s]);
    for (const std::uint32_t f : star.faces) first_point_[f] = kNone;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const Vec3 twice = (at(star.ring[kept_[i]]) - pj).cross(at(star.ring_at(kept_[i] + 1)) - pj);
      const Vec3 scan = sums_[i];
      face_normal_[star.faces[kept_[i]]] = scan.norm() > 0.25 * twice.norm() / 2 ? scan : twice / 2;
    }
    for (const Moved& moved : moved_) {
      const std::size_t m = kept_[moved.kept];
      const std::uint32_t f = star.faces[m];
      // The kept face has the collapsed vertex, soon the target, at this corner.
      const std::uint32_t c = corner_of(faces_[f], current_vertex(star, m));
      DomainPoint& p = point_[moved.point];
      p.face = f;
      for (std::uint32_t k = 0; k < 3; ++k) p.weight[(c + k) % 3] = moved.weight[k];
      next_point_[moved.point] = first_point_[f];
      first_point_[f] = moved.point;
    }
  }

  /// The centre of a star, as the one corner of face m that is not on the ring.
  [[nodiscard]] std::uint32_t current_vertex(const Star& star, std::size_t m) const {
    for (const std::uint32_t v : faces_[star.faces[m]])
      if (v != star.ring[m] && v != star.ring_at(m + 1)) return v;
    return kNone;
  }

  /// Joins the neighbours of the two faces (one on the boundary) that vanish.
  void relink(const Star& star, std::size_t s) {
    const std::size_t k = star.faces.size(), n = star.ring.size();
    const auto vanish = [&](std::size_t m, std::size_t inner) {
      const std::uint32_t f = star.faces[m];
      const std::uint32_t kept = star.faces[inner];
      // Of the vanishing face's three sides one leads to `kept`, one to the other vanishing face
      // (or the boundary), one outward, opposite to the collapsed vertex.
      std::uint32_t outer = kNone, outer_side = 0;
      for (std::uint32_t x = 0; x < 3; ++x) {
        const std::uint32_t a = faces_[f][x], b = faces_[f][(x + 1) % 3];
        if ((a == star.ring[m] && b == star.ring_at(m + 1))) outer = neighbors_[f][x];
      }
      for (std::uint32_t x = 0; x < 3; ++x)
        if (neighbors_[kept][x] == f) neighbors_[kept][x] = outer;
      if (outer != kNone) {
        for (std::uint32_t x = 0; x < 3; ++x)
          if (neighbors_[outer][x] == f) outer_side = x;
        neighbors_[outer][outer_side] = kept;
      }
      dead_face_[f] = 1;
      face_of_[star.ring[m]] = kept;
      face_of_[star.ring_at(m + 1)] = kept;
    };
    if (!star.boundary) {
      vanish(s, (s + 1) % k);
      vanish((s + k - 1) % k, (s + 2 * k - 2) % k);
    } else if (s == 0) {
      vanish(0, 1);
    } else {
      vanish(n - 2, n - 3);
    }
    for (const std::size_t m : kept_) {
      face_of_[star.ring[m]] = star.faces[m];
      face_of_[star.ring_at(m + 1)] = star.faces[m];
      face_of_[star.ring[s]] = star.faces[m];
    }
  }

  Parameterisation finish() {
    Parameterisation out;
    std::vector<std::uint32_t> new_vertex(dead_vertex_.size(), kNone),
        new_face(faces_.size(), kNone);
    for (std::uint32_t v = 0; v < dead_vertex_.size(); ++v) {
      if (dead_vertex_[v]) continue;
      new_vertex[v] = static_cast<std::uint32_t>(out.base.scan_vertex.size());
      out.base.scan_vertex.push_back(v);
    }
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (dead_face_[f]) continue;
      new_face[f] = static_cast<std::uint32_t>(out.base.triangles.size());
      const Triangle& t = faces_[f];
      out.base.triangles.push_back({new_vertex[t[0]], new_vertex[t[1]], new_vertex[t[2]]});
    }
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (dead_face_[f]) continue;
      Triangle n = neighbors_[f];
      for (std::uint32_t& x : n) x = x == kNone ? kNone : new_face[x];
      out.base.neighbors.push_back(n);
    }
    out.point = std::move(point_);
    for (std::uint32_t v = 0; v < dead_vertex_.size(); ++v) {
      DomainPoint& p = out.point[v];
      if (dead_vertex_[v]) {
        p.face = new_face[p.face];
        continue;
      }
      p.face = new_face[face_of_[v]];
      p.weight = {};
      p.weight[corner_of(out.base.triangles[p.face], new_vertex[v])] = 1;
    }
    return out;
  }

  const Scan& scan_;
  const SimplifyOptions& options_;
  Importance importance_;
  Vec3 centre_ = Vec3::Zero();  // quadrics are relative to it: they lose what is far from zero
  std::vector<Triangle> faces_, neighbors_;
  std::vector<std::uint32_t> face_of_;
  std::vector<Quadric> quadric_;
  std::vector<std::uint32_t> stamp_;
  std::vector<char> stale_, blocked_, dead_vertex_, dead_face_, on_boundary_;
  std::vector<DomainPoint> point_;
  std::vector<std::uint32_t> next_point_, first_point_;
  std::vector<Vec3> area_vector_;  // of each scan vertex: a third of its faces'
  std::vector<Vec3> face_normal_;  // scan area vector that each current face stands for
  std::priority_queue<Entry> queue_;
  std::size_t alive_ = 0;
  double total_error_ = 0;  // Σ over vertices of their quadric at their place

  Scratch scratch_;
  mutable std::vector<Vec3> sums_;
  std::vector<std::size_t> kept_;
  std::vector<Moved> moved_;
};

}  // namespace

Result<Parameterisation> simplify(const Scan& scan, const SimplifyOptions& options,
                                  const Importance& importance, const RunContext& context) {
  return Simplifier(scan, options, importance).run(context);
}

}  // namespace nacre::remesh
