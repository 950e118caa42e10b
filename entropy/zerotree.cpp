// SPDX-License-Identifier: Apache-2.0
//
// Read me first: set partitioning as in SPIHT, over trees of edges. A plane sends, for each
// component: whether the coefficients not found yet reach 2^plane; whether the trees not opened yet
// hold one that does; then the plane's bit of all that were found earlier. The code is a number of
// yes-or-no decisions, stated at its start, so it can end anywhere.
#include "entropy/zerotree.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdlib>

#include "entropy/adaptive_bit.h"
#include "entropy/arithmetic.h"
#include "entropy/binary_model.h"

namespace nacre::entropy {
namespace {

constexpr int kPlaneBits = 5, kLengthBits = 6;
constexpr std::size_t kLeastBytes = 16;

/// Edges of all coded levels in one numbering, coarse to fine.
class EdgeForest {
 public:
  struct Children {
    std::array<std::uint32_t, 4> node;
    int count = 0;
  };

  EdgeForest(const Topology& topology, int band_count) : topology_(topology) {
    begin_.push_back(0);
    for (int j = 0; j < band_count; ++j)
      begin_.push_back(begin_.back() + static_cast<std::uint32_t>(topology.level(j).edges.size()));
  }

  [[nodiscard]] int band_count() const { return static_cast<int>(begin_.size()) - 1; }
  [[nodiscard]] std::uint32_t size() const { return begin_.back(); }
  [[nodiscard]] std::uint32_t root_count() const { return begin_[1]; }
  [[nodiscard]] std::uint32_t begin(int band) const {
    return begin_[static_cast<std::size_t>(band)];
  }
  [[nodiscard]] int band_of(std::uint32_t node) const {
    return static_cast<int>(std::upper_bound(begin_.begin(), begin_.end(), node) - begin_.begin()) -
           1;
  }
  [[nodiscard]] bool has_children(std::uint32_t node) const {
    return node < begin_[begin_.size() - 2];
  }

  /// The two halves of the edge, and in each of its faces the new edge parallel to it; none on the
  /// finest band.
  [[nodiscard]] Children children(std::uint32_t node) const {
    Children out;
    if (!has_children(node)) return out;
    const int band = band_of(node);
    const LevelTopology& level = topology_.level(band);
    const std::uint32_t e = node - begin(band), finer = begin(band + 1);
    const auto edges = static_cast<std::uint32_t>(level.edges.size());
    out.node = {finer + 2 * e, finer + 2 * e + 1, 0, 0};
    out.count = 2;
    for (const std::uint32_t face : level.edges[e].face) {
      if (face == kNone) continue;
      const Triangle& sides = level.triangle_edges[face];
      const std::uint32_t side = sides[0] == e ? 0 : (sides[1] == e ? 1 : 2);
      // The edge that cuts off the corner opposite side s, which is corner s + 2.
      out.node[static_cast<std::size_t>(out.count++)] =
          finer + 2 * edges + 3 * face + (side + 2) % 3;
    }
    return out;
  }

  /// Of a node that is no root.
  [[nodiscard]] std::uint32_t parent(std::uint32_t node) const {
    const int band = band_of(node);
    const LevelTopology& level = topology_.level(band - 1);
    const auto edges = static_cast<std::uint32_t>(level.edges.size());
    const std::uint32_t e = node - begin(band);
    if (e < 2 * edges) return begin(band - 1) + e / 2;
    const std::uint32_t face = (e - 2 * edges) / 3, corner = (e - 2 * edges) % 3;
    return begin(band - 1) + level.triangle_edges[face][(corner + 1) % 3];
  }

 private:
  const Topology& topology_;
  std::vector<std::uint32_t> begin_;
};

/// What an encoder knows of one component beforehand.
struct Truth {
  std::vector<std::int32_t> value;
  std::vector<std::int32_t> below;      ///< largest magnitude among all descendants
  std::vector<std::int32_t> far_below;  ///< the same without the children
};

/// One component as decoded so far, and what is still open.
struct Component {
  struct OpenSet {
    std::uint32_t node;
    bool without_children;
  };
  std::vector<std::int32_t> magnitude;  ///< 0: not found yet
  std::vector<std::uint8_t> negative, plane;
  std::vector<std::uint8_t> is_open;  ///< the set of all descendants was found to hold something
  std::vector<std::uint32_t> waiting, found;
  std::vector<OpenSet> sets;
};

struct Writer {
  ArithmeticEncoder coder;
  std::uint64_t left = 0;            ///< decisions
  std::uint64_t cost = 0;            ///< of those made, in 1/4096 bit
  std::uint64_t cost_limit = ~0ull;  ///< no decision is begun above it

  [[nodiscard]] bool stopped() const { return left == 0 || cost >= cost_limit; }
  bool bit(AdaptiveBit& model, bool value) {
    --left;
    cost += bit_cost(model.probability_of(value));
    coder.encode_bit(value, model.probability());
    model.update(value);
    return value;
  }
  bool raw_bit(bool value) {
    --left;
    cost += 4096;
    coder.encode_bits(value ? 1 : 0, 1);
    return value;
  }
};

struct Reader {
  ArithmeticDecoder coder;
  std::uint64_t left = 0;

  [[nodiscard]] bool stopped() const { return left == 0 || coder.overrun(); }
  bool bit(AdaptiveBit& model, bool) {
    --left;
    const bool value = coder.decode_bit(model.probability());
    model.update(value);
    return value;
  }
  bool raw_bit(bool) {
    --left;
    return coder.decode_bits(1) != 0;
  }
};

/// Statistics, by whether the component is tangential. "Family" is the four children of one edge.
struct Models {
  std::array<std::array<AdaptiveBit, 8>, 2> waiting;  ///< found in the family, parent found
  std::array<std::array<std::array<AdaptiveBit, 16>, 2>, 2> child;  ///< parent found; place, found
  std::array<AdaptiveBit, 2> root;
  std::array<std::array<std::array<AdaptiveBit, 4>, 2>, 2> set;  ///< node found; open siblings
  std::array<std::array<AdaptiveBit, 5>, 2> far_set;             ///< children found
  std::array<std::array<AdaptiveBit, 2>, 2> refinement;          ///< first one or later
};

template <class Io>
class Zerotree {
 public:
  /// `truth` is empty for a reader.
  Zerotree(const EdgeForest& forest, Io& io, std::span<const Truth> truth)
      : forest_(forest), io_(io), truth_(truth) {
    for (Component& c : components) {
      c.magnitude.assign(forest.size(), 0);
      c.negative.assign(forest.size(), 0);
      c.plane.assign(forest.size(), 0);
      c.is_open.assign(forest.size(), 0);
      for (std::uint32_t root = 0; root < forest.root_count(); ++root) {
        c.waiting.push_back(root);
        if (forest.has_children(root)) c.sets.push_back({root, false});
      }
    }
  }

  void run(int plane_count) {
    for (plane_ = plane_count - 1; plane_ >= 0; --plane_) {
      std::array<std::size_t, 3> found_before{};
      for (std::size_t c = 0; c < 3; ++c) found_before[c] = components[c].found.size();
      for (c_ = 0; c_ < 3; ++c_) {
        look_at_waiting();
        look_at_sets();
      }
      for (c_ = 0; c_ < 3; ++c_) refine(found_before[c_]);
      if (io_.stopped()) return;
    }
  }

  std::array<Component, 3> components;

 private:
  [[nodiscard]] std::size_t kind() const { return c_ == 0 ? 0 : 1; }
  [[nodiscard]] bool is_found(std::uint32_t node) const {
    return components[c_].magnitude[node] != 0;
  }
  /// Whether a magnitude of the encoder's reaches the plane; anything for a reader.
  [[nodiscard]] bool reaches(const std::vector<std::int32_t> Truth::*of, std::uint32_t node) const {
    return !truth_.empty() && (std::abs((truth_[c_].*of)[node]) >> plane_) != 0;
  }

  /// Asks for a coefficient's significance and sign. False if it stays unknown or is not.
  bool find(std::uint32_t node, AdaptiveBit& model) {
    if (io_.stopped() || !io_.bit(model, reaches(&Truth::value, node))) return false;
    // Without its sign it says nothing.
    if (io_.stopped()) return false;
    Component& c = components[c_];
    c.negative[node] = io_.raw_bit(!truth_.empty() && truth_[c_].value[node] < 0) ? 1 : 0;
    c.magnitude[node] = std::int32_t{1} << plane_;
    c.plane[node] = static_cast<std::uint8_t>(plane_);
    c.found.push_back(node);
    return true;
  }

  AdaptiveBit& waiting_model(std::uint32_t node) {
    if (node < forest_.root_count()) return models_.root[kind()];
    const std::uint32_t parent = forest_.parent(node);
    const auto family = forest_.children(parent);
    std::size_t found = 0;
    for (int i = 0; i < family.count; ++i) {
      const std::uint32_t sibling = family.node[static_cast<std::size_t>(i)];
      if (sibling != node && is_found(sibling)) ++found;
    }
    return models_.waiting[kind()][2 * found + (is_found(parent) ? 1 : 0)];
  }

  void look_at_waiting() {
    std::vector<std::uint32_t>& waiting = components[c_].waiting;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      const std::uint32_t node = waiting[i];
      if (!find(node, waiting_model(node))) waiting[kept++] = node;
    }
    waiting.resize(kept);
  }

  AdaptiveBit& set_model(std::uint32_t node) {
    std::size_t open = 0;
    if (node >= forest_.root_count()) {
      const auto family = forest_.children(forest_.parent(node));
      for (int i = 0; i < family.count; ++i)
        open += components[c_].is_open[family.node[static_cast<std::size_t>(i)]];
    }
    return models_.set[kind()][is_found(node) ? 1 : 0][std::min<std::size_t>(open, 3)];
  }

  /// Children of a set that opens: found, or waiting from now on.
  void open_children(std::uint32_t node) {
    Component& c = components[c_];
    c.is_open[node] = 1;
    const auto family = forest_.children(node);
    std::size_t found = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(family.count); ++i) {
      AdaptiveBit& model = models_.child[kind()][is_found(node) ? 1 : 0][4 * i + found];
      if (find(family.node[i], model))
        ++found;
      else
        c.waiting.push_back(family.node[i]);
    }
    if (forest_.has_children(family.node[0])) c.sets.push_back({node, true});
  }

  void look_at_sets() {
    Component& c = components[c_];
    std::size_t kept = 0;
    for (std::size_t i = 0; i < c.sets.size(); ++i) {
      const auto set = c.sets[i];
      if (io_.stopped()) return;
      if (!set.without_children) {
        if (io_.bit(set_model(set.node), reaches(&Truth::below, set.node)))
          open_children(set.node);
        else
          c.sets[kept++] = set;
        continue;
      }
      const auto family = forest_.children(set.node);
      std::size_t found = 0;
      for (int k = 0; k < family.count; ++k)
        if (is_found(family.node[static_cast<std::size_t>(k)])) ++found;
      if (!io_.bit(models_.far_set[kind()][found], reaches(&Truth::far_below, set.node))) {
        c.sets[kept++] = set;
        continue;
      }
      for (int k = 0; k < family.count; ++k)
        c.sets.push_back({family.node[static_cast<std::size_t>(k)], false});
    }
    c.sets.resize(kept);
  }

  void refine(std::size_t count) {
    Component& c = components[c_];
    for (std::size_t i = 0; i < count && !io_.stopped(); ++i) {
      const std::uint32_t node = c.found[i];
      const bool first = (c.magnitude[node] >> (plane_ + 1)) == 1;
      const bool truth = !truth_.empty() && ((std::abs(truth_[c_].value[node]) >> plane_) & 1) != 0;
      if (io_.bit(models_.refinement[kind()][first ? 0 : 1], truth))
        c.magnitude[node] |= std::int32_t{1} << plane_;
      c.plane[node] = static_cast<std::uint8_t>(plane_);
    }
  }

  const EdgeForest& forest_;
  Io& io_;
  std::span<const Truth> truth_;
  Models models_;
  int plane_ = 0;
  std::size_t c_ = 0;
};

std::vector<Truth> truth_of(const EdgeForest& forest,
                            std::span<const std::vector<ZerotreePoint>> points) {
  std::vector<Truth> all(3);
  for (std::size_t c = 0; c < 3; ++c) {
    Truth& truth = all[c];
    for (const auto& band : points)
      for (const ZerotreePoint& p : band) truth.value.push_back(p[c]);
    truth.below.assign(forest.size(), 0);
    truth.far_below.assign(forest.size(), 0);
    for (std::uint32_t node = forest.size(); node-- > 0;) {
      const auto family = forest.children(node);
      for (int i = 0; i < family.count; ++i) {
        const std::uint32_t child = family.node[static_cast<std::size_t>(i)];
        truth.far_below[node] = std::max(truth.far_below[node], truth.below[child]);
        truth.below[node] = std::max(truth.below[node], std::abs(truth.value[child]));
      }
      truth.below[node] = std::max(truth.below[node], truth.far_below[node]);
    }
  }
  return all;
}

int plane_count_of(std::span<const std::vector<ZerotreePoint>> points) {
  std::uint32_t all = 0;
  for (const auto& band : points)
    for (const ZerotreePoint& p : band)
      for (const std::int32_t v : p) all |= static_cast<std::uint32_t>(std::abs(v));
  return static_cast<int>(std::bit_width(all));
}

/// Planes, then the number of decisions as its length and the bits below its leading one.
std::vector<std::uint8_t> encode_decisions(const EdgeForest& forest, std::span<const Truth> truth,
                                           int plane_count, std::uint64_t decisions) {
  Writer writer;
  writer.coder.encode_bits(static_cast<std::uint32_t>(plane_count), kPlaneBits);
  const int length = static_cast<int>(std::bit_width(decisions));
  writer.coder.encode_bits(static_cast<std::uint32_t>(length), kLengthBits);
  for (int i = length - 2; i >= 0; --i)
    writer.coder.encode_bits(static_cast<std::uint32_t>(decisions >> i) & 1u, 1);
  writer.left = decisions;
  Zerotree(forest, writer, truth).run(plane_count);
  return writer.coder.finish();
}

}  // namespace

std::vector<std::uint8_t> encode_zerotree(const Topology& topology,
                                          std::span<const std::vector<ZerotreePoint>> points,
                                          std::size_t max_bytes) {
  const int plane_count = plane_count_of(points);
  assert(plane_count <= kMaxZerotreePlanes);
  if (points.empty() || plane_count == 0 || max_bytes < kLeastBytes) return {};
  const EdgeForest forest(topology, static_cast<int>(points.size()));
  const std::vector<Truth> truth = truth_of(forest, points);

  // Costs are estimates within a percent, so the end is corrected on the real size.
  constexpr std::uint64_t kAll = std::uint64_t{1} << 48;
  const auto decisions_within = [&](std::uint64_t bits) {
    Writer writer;
    writer.left = kAll;
    writer.cost_limit = 4096 * bits;
    Zerotree(forest, writer, truth).run(plane_count);
    return kAll - writer.left;
  };
  std::uint64_t bits = 8 * max_bytes - 40;
  while (true) {
    const std::uint64_t decisions = decisions_within(bits);
    if (decisions == 0) return {};
    auto payload = encode_decisions(forest, truth, plane_count, decisions);
    if (payload.size() <= max_bytes) return payload;
    const std::uint64_t excess = 8 * (payload.size() - max_bytes) + 4;
    if (excess >= bits) return {};
    bits -= excess;
  }
}

Result<ZerotreeBands> decode_zerotree(std::span<const std::uint8_t> payload,
                                      const Topology& topology, int band_count) {
  assert(band_count >= 1);
  const EdgeForest forest(topology, band_count);
  const auto corrupt = [&](const char* what) {
    return Error{ErrorCode::kCorruptStream, what, payload.size()};
  };
  Reader reader{ArithmeticDecoder(payload), 0};
  ZerotreeBands out;
  out.points.resize(static_cast<std::size_t>(band_count));
  out.planes.resize(static_cast<std::size_t>(band_count));
  int plane_count = 0;
  if (!payload.empty()) {
    plane_count = static_cast<int>(reader.coder.decode_bits(kPlaneBits));
    const auto length = static_cast<int>(reader.coder.decode_bits(kLengthBits));
    if (plane_count < 1 || plane_count > kMaxZerotreePlanes || length < 1 || length > 48)
      return corrupt("the bit planes' head is out of range");
    reader.left = 1;
    for (int i = 1; i < length; ++i) reader.left = (reader.left << 1) | reader.coder.decode_bits(1);
  }
  Zerotree tree(forest, reader, {});
  tree.run(plane_count);
  if (reader.left != 0) return corrupt("the bit planes end before their code does");
  if (!reader.coder.ends_exactly()) return corrupt("the bit planes do not end with their code");
  for (int j = 0; j < band_count; ++j) {
    const std::uint32_t begin = forest.begin(j), end = forest.begin(j + 1);
    auto& points = out.points[static_cast<std::size_t>(j)];
    auto& planes = out.planes[static_cast<std::size_t>(j)];
    points.resize(end - begin);
    planes.resize(end - begin);
    for (std::uint32_t node = begin; node < end; ++node) {
      for (std::size_t c = 0; c < 3; ++c) {
        const Component& component = tree.components[c];
        const std::int32_t m = component.magnitude[node];
        points[node - begin][c] = component.negative[node] != 0 ? -m : m;
        planes[node - begin][c] = component.plane[node];
      }
    }
  }
  return out;
}

}  // namespace nacre::entropy
