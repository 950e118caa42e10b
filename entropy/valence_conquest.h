// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "entropy/connectivity.h"
#include "entropy/connectivity_models.h"
#include "entropy/symbol_io.h"
#include "entropy/valence_front.h"

/// The traversal and the symbols of a coded connectivity, once for both directions. A `Guide` says
/// what the mesh looks like where the traversal stands; the decoder's guide knows nothing, as the
/// reader needs no proposals.
namespace nacre::entropy {

/// The vertex of a new triangle: a new one, or one on the front.
struct Step {
  bool joins = false;
  bool dummy = false;         // new vertices
  std::uint32_t valence = 0;  // new vertices
  std::uint32_t other = 0;    // joins: a node ...
  std::uint32_t skipped = 0;  // ... and the slots between its successor and the triangle
};

/// The first triangle of a component. Corner 0 is a dummy if the component has a boundary.
struct Start {
  Triangle valences{};
  std::uint32_t boundary_loops = 0;
};

template <class Io, class Guide>
class ValenceConquest {
 public:
  ValenceConquest(Io& io, Guide& guide, std::uint32_t max_triangles)
      : io_(io), guide_(guide), max_triangles_(max_triangles) {}

  /// False if the symbols make no closed triangulation, or one with too many triangles.
  [[nodiscard]] bool run() {
    while (true) {
      const std::optional<Start> proposed = guide_.next_component();
      const int kind = !proposed
                           ? kNoComponent
                           : (proposed->boundary_loops > 0 ? kOpenComponent : kClosedComponent);
      const int coded = io_.symbol(kind, models_.component);
      if (io_.failed()) return false;
      if (coded == kNoComponent) return true;
      if (!start(coded == kOpenComponent, proposed.value_or(Start{}))) return false;
      while (!front_.empty()) {
        if (!triangle(front_.focus())) return false;
      }
      if (dummies_left_ > 0) return false;
    }
  }

  [[nodiscard]] Connectivity& result() { return result_; }

 private:
  std::uint32_t new_vertex(bool dummy) { return dummy ? kNone : result_.vertex_count++; }

  [[nodiscard]] bool emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == kNone || b == kNone || c == kNone) {
      // A triangle has at most three neighbours outside.
      return ++dummy_triangles_ <= 3 * std::uint64_t{max_triangles_};
    }
    result_.triangles.push_back({a, b, c});
    return result_.triangles.size() <= max_triangles_;
  }

  std::uint32_t code_valence(std::uint32_t valence, AdaptiveModel& model) {
    const std::uint32_t last = kFirstValence + kValenceSymbols - 1;
    const bool listed = valence >= kFirstValence && valence < last;
    const int symbol =
        io_.symbol(static_cast<int>(listed ? valence - kFirstValence : kValenceSymbols - 1), model);
    if (symbol < static_cast<int>(kValenceSymbols) - 1)
      return kFirstValence + static_cast<std::uint32_t>(symbol);
    // Escape: 0 stands for valence 2, which only a closed pair of triangles has.
    const std::uint32_t rest =
        code_number(io_, valence == 2 ? 0 : valence - last + 1, models_.large);
    return rest == 0 ? 2 : last + std::min(rest, kMaxValence) - 1;
  }

  std::uint32_t code_dummy_valence(std::uint32_t valence) {
    return kFirstValence +
           std::min(code_number(io_, valence - kFirstValence, models_.dummy), kMaxValence);
  }

  [[nodiscard]] bool start(bool open, const Start& proposed) {
    Start s = proposed;
    if (open) {
      s.boundary_loops = 1 + code_number(io_, s.boundary_loops - 1, models_.loops);
      dummies_left_ = s.boundary_loops - 1;
      s.valences[0] = code_dummy_valence(s.valences[0]);
    } else {
      s.valences[0] = code_valence(s.valences[0], models_.valence);
    }
    AdaptiveModel& model = open ? models_.boundary : models_.valence;
    for (int k = 1; k < 3; ++k) s.valences[k] = code_valence(s.valences[k], model);
    if (io_.failed()) return false;
    Triangle vertices;
    for (int k = 0; k < 3; ++k) vertices[k] = new_vertex(open && k == 0);
    const Triangle nodes = front_.open(vertices, s.valences, {open, false, false});
    guide_.started(nodes);
    return emit(vertices[0], vertices[1], vertices[2]);
  }

  [[nodiscard]] bool triangle(std::uint32_t node) {
    const std::uint32_t p = front_[node].previous, n = front_[node].next;
    const std::uint32_t v = front_[node].vertex;
    if (front_[node].slots == 0) {
      const std::uint32_t a = front_[p].vertex, b = front_[n].vertex;
      guide_.closing(node, p);
      return front_.close(node) && emit(a, v, b);
    }
    const Step step = code_step(node, guide_.propose(front_, node));
    if (io_.failed()) return false;
    if (!step.joins) {
      const std::uint32_t x = new_vertex(step.dummy);
      const std::uint32_t x_node = front_.add(node, x, step.valence, step.dummy);
      if (x_node == kNone) return false;
      if (step.dummy) --dummies_left_;
      guide_.added(node, x_node);
      return emit(v, front_[n].vertex, x);
    }
    ValenceFront::Joined joined{};
    if (!front_.join(node, step.other, step.skipped, joined)) return false;
    guide_.joined(node, joined.after_focus, joined.before_successor);
    return emit(v, front_[n].vertex, front_[step.other].vertex);
  }

  Step code_step(std::uint32_t node, const Step& proposed) {
    Step step = proposed;
    const std::uint64_t joins = front_.join_count(node);
    if (joins > 0)
      step.joins = io_.symbol(step.joins ? 1 : 0, models_.joins) == 1;
    else
      step.joins = false;
    if (step.joins) {
      code_join(node, joins, step);
      return step;
    }
    step.dummy = dummies_left_ > 0 && io_.symbol(step.dummy ? 1 : 0, models_.is_dummy) == 1;
    if (step.dummy) {
      step.valence = code_dummy_valence(step.valence);
    } else {
      step.valence =
          code_valence(step.valence, front_[node].dummy ? models_.boundary : models_.valence);
    }
    return step;
  }

  void code_join(std::uint32_t node, std::uint64_t joins, Step& step) {
    // Valences are below 2^30, but a forged sum of them could be longer.
    const auto range = static_cast<std::uint32_t>(std::min<std::uint64_t>(joins, kNone - 1));
    const std::uint64_t index = Io::kReads ? 0 : front_.join_index(node, step.other, step.skipped);
    const std::uint32_t place =
        std::min(code_uniform(io_, static_cast<std::uint32_t>(index), range), range - 1);
    const ValenceFront::JoinPlace at = front_.join_place(node, place);
    step.other = at.other;
    step.skipped = at.skipped;
  }

  Io& io_;
  Guide& guide_;
  std::uint32_t max_triangles_;
  ConnectivityModels models_;
  ValenceFront front_;
  Connectivity result_;
  std::uint32_t dummies_left_ = 0;
  std::uint64_t dummy_triangles_ = 0;
};

}  // namespace nacre::entropy
