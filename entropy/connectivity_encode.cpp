// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cassert>
#include <utility>

#include "entropy/closed_mesh.h"
#include "entropy/connectivity.h"
#include "entropy/valence_conquest.h"

namespace nacre::entropy {
namespace {

/// Where the traversal of one component may begin: any half-edge of a closed one, one that starts
/// at a dummy in an open one.
struct Component {
  std::vector<std::uint32_t> starts;
  std::uint32_t boundary_loops = 0;
};

std::vector<Component> find_components(const ClosedMesh& mesh) {
  std::vector<Component> components;
  std::vector<bool> seen(mesh.triangles.size(), false);
  std::vector<bool> counted(mesh.valences.size(), false);
  std::vector<std::uint32_t> queue;
  for (std::uint32_t first = 0; first < mesh.triangles.size(); ++first) {
    if (seen[first]) continue;
    Component component;
    queue.assign(1, first);
    seen[first] = true;
    for (std::size_t at = 0; at < queue.size(); ++at) {
      for (std::uint32_t h = 3 * queue[at]; h < 3 * queue[at] + 3; ++h) {
        const std::uint32_t v = mesh.from(h), across = mesh.twins[h] / 3;
        if (mesh.is_dummy(v)) {
          component.starts.push_back(h);
          if (!counted[v]) ++component.boundary_loops;
          counted[v] = true;
        }
        if (!seen[across]) queue.push_back(across);
        seen[across] = true;
      }
    }
    if (component.boundary_loops == 0) {
      for (const std::uint32_t f : queue)
        for (std::uint32_t k = 0; k < 3; ++k) component.starts.push_back(3 * f + k);
    }
    components.push_back(std::move(component));
  }
  return components;
}

/// Follows a conquest on the mesh that is being coded.
class MeshGuide {
 public:
  MeshGuide(const ClosedMesh& mesh, std::span<const Component> components,
            std::span<const std::uint32_t> starts)
      : mesh_(mesh),
        components_(components),
        starts_(starts),
        coded_(mesh.triangles.size(), false),
        known_(mesh.valences.size(), false),
        node_at_(mesh.twins.size(), kNone) {}

  std::optional<Start> next_component() {
    if (at_ == components_.size()) return std::nullopt;
    start_ = starts_[at_];
    Start start;
    for (int k = 0; k < 3; ++k) start.valences[k] = mesh_.valences[mesh_.from(side(k))];
    start.boundary_loops = components_[at_++].boundary_loops;
    return start;
  }

  void started(const Triangle& nodes) {
    coded_[start_ / 3] = true;
    for (int k = 0; k < 3; ++k) {
      meet(mesh_.from(side(k)));
      set_edge(nodes[(k + 1) % 3], mesh_.twins[side(k)]);
    }
  }

  void closing(std::uint32_t node, std::uint32_t previous) {
    const std::uint32_t h = edge_of_[node];
    coded_[h / 3] = true;
    set_edge(previous, mesh_.twins[next_side(h)]);
  }

  Step propose(const ValenceFront&, std::uint32_t node) {
    std::uint32_t at = previous_side(edge_of_[node]);
    const std::uint32_t x = mesh_.from(at);
    if (!known_[x]) return {.dummy = mesh_.is_dummy(x), .valence = mesh_.valences[x]};
    std::uint32_t turned = 0;  // triangles of x's wedge before the one to be coded
    for (; !coded_[mesh_.twins[at] / 3]; ++turned) at = next_side(mesh_.twins[at]);
    return {.joins = true, .other = node_at_[at], .skipped = turned - 1};
  }

  void added(std::uint32_t node, std::uint32_t new_node) {
    const std::uint32_t h = edge_of_[node];
    meet(mesh_.from(previous_side(h)));
    code_triangle(h, node, new_node);
  }

  void joined(std::uint32_t node, std::uint32_t after_focus, std::uint32_t before_successor) {
    const std::uint32_t h = edge_of_[node];
    set_edge(after_focus, edge_of_[after_focus]);
    code_triangle(h, node, before_successor);
  }

  [[nodiscard]] std::vector<std::uint32_t> take_order() { return std::move(order_); }

 private:
  /// The start triangle's side k, counted from the start half-edge.
  [[nodiscard]] std::uint32_t side(int k) const {
    return k == 0 ? start_ : (k == 1 ? next_side(start_) : previous_side(start_));
  }

  void meet(std::uint32_t vertex) {
    known_[vertex] = true;
    if (!mesh_.is_dummy(vertex)) order_.push_back(vertex);
  }

  /// The triangle on half-edge h was coded: the front now runs along its two other sides.
  void code_triangle(std::uint32_t h, std::uint32_t node, std::uint32_t apex_node) {
    coded_[h / 3] = true;
    set_edge(node, mesh_.twins[previous_side(h)]);
    set_edge(apex_node, mesh_.twins[next_side(h)]);
  }

  void set_edge(std::uint32_t node, std::uint32_t half_edge) {
    if (node >= edge_of_.size()) edge_of_.resize(node + 1, kNone);
    edge_of_[node] = half_edge;
    node_at_[half_edge] = node;
  }

  const ClosedMesh& mesh_;
  std::span<const Component> components_;
  std::span<const std::uint32_t> starts_;
  std::size_t at_ = 0;
  std::uint32_t start_ = kNone;
  std::vector<bool> coded_, known_;
  std::vector<std::uint32_t> node_at_;  // front half-edge → node
  std::vector<std::uint32_t> edge_of_;  // node → its front half-edge
  std::vector<std::uint32_t> order_;
};

EncodedConnectivity encode_from(const ClosedMesh& mesh, std::span<const Component> components,
                                std::span<const std::uint32_t> starts) {
  SymbolWriter writer;
  MeshGuide guide(mesh, components, starts);
  ValenceConquest<SymbolWriter, MeshGuide> conquest(
      writer, guide, static_cast<std::uint32_t>(mesh.triangles.size()));
  const bool ok = conquest.run();
  assert(ok);
  static_cast<void>(ok);
  return {writer.finish(), std::move(conquest.result()), guide.take_order()};
}

// Where the traversal starts decides how often it runs into itself: a few per cent of the bytes.
// Small meshes, whose every byte counts, can afford to try many starts.
constexpr std::size_t kTriangleVisits = 60000;
constexpr std::size_t kMaxTrials = 64;

}  // namespace

Result<EncodedConnectivity> encode_connectivity(std::span<const Triangle> triangles,
                                                std::uint32_t vertex_count) {
  const Result<ClosedMesh> mesh = close_mesh(triangles, vertex_count);
  if (!mesh) return mesh.error();
  const std::vector<Component> components = find_components(*mesh);
  const std::size_t trials =
      std::clamp(kTriangleVisits / (triangles.size() + 1), std::size_t{1}, kMaxTrials);
  EncodedConnectivity best;
  std::vector<std::uint32_t> starts(components.size());
  for (std::size_t trial = 0; trial < trials; ++trial) {
    for (std::size_t c = 0; c < components.size(); ++c) {
      const auto& choices = components[c].starts;
      // Multiples of the golden ratio spread evenly over [0, 2^32).
      const auto spread = static_cast<std::uint32_t>(trial * 2654435769u);
      starts[c] = choices[(std::uint64_t{spread} * choices.size()) >> 32];
    }
    EncodedConnectivity encoded = encode_from(*mesh, components, starts);
    if (trial == 0 || encoded.bytes.size() < best.bytes.size()) best = std::move(encoded);
  }
  return best;
}

}  // namespace nacre::entropy
