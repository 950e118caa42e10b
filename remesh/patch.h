// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "remesh/refinement.h"

namespace nacre::remesh {

/// Unfolds what no vertex can mend alone: all vertices within some rings of a folded triangle go,
/// again and again, to the middle of their neighbours, on the scan or in the domain, in patches
/// that grow until the fold is gone.
class PatchUnfolder {
 public:
  /// Which vertices may move: those that the level adds, or the older ones too. On the boundary:
  /// none.
  enum class Movable : std::uint8_t { kNewest, kAll };

  PatchUnfolder(Refinement& mesh, int level, Movable movable)
      : mesh_(mesh), topology_(mesh.topology()), level_(level), movable_(movable) {}

  /// Makes at most about `most_moves` moves. Returns  the triangles that are folded afterwards,
  /// ascending, if `folded` has all that were.
  std::vector<std::uint32_t> run(std::vector<std::uint32_t> folded, std::size_t most_moves);

  /// For the few that run() leaves: tries places for each vertex around the given triangles, on the
  /// scan, as near to its own as will do; as the last resort leaves the newest on the coarser
  /// level's triangles, off the scan. Takes up to half a second.
  void search(std::vector<std::uint32_t> folded);

 private:
  enum class Middle : std::uint8_t { kInSpace, kInDomain };
  struct Attempt {
    bool from_edges;  // else from where they are
    Middle middle;
  };
  static const std::array<Attempt, 3> kAttempts;

  void mend(std::uint32_t folded_triangle, int rings);
  void collect(std::uint32_t folded_triangle, int rings);
  bool collect_around(std::uint32_t vertex, std::uint32_t triangle,
                      std::vector<std::uint32_t>& triangles);
  void smooth(Middle middle);
  bool note_if_better();
  void go_to_edges();
  void move(std::size_t i, Middle middle);
  [[nodiscard]] std::optional<SurfacePoint> middle_in_domain(std::size_t i);
  void move_to(std::uint32_t vertex, const SurfacePoint& point, const Vec3& middle, double radius);
  template <class BadnessAt>
  void give_back(const std::vector<Refinement::Place>& before, const BadnessAt& badness_at);
  void give_back_missed(const std::vector<Refinement::Place>& before, double most);
  [[nodiscard]] Vec3 middle_of_ring(std::size_t i) const;
  [[nodiscard]] double radius_around(std::size_t i, const Vec3& middle) const;

  void mend_by_search(std::uint32_t folded_triangle, int rings);
  bool flatten();
  void descend(const std::vector<Refinement::Place>& before);
  bool improve(std::size_t i, const Vec3& before);
  void collect_places(std::size_t i, const Vec3& middle);
  [[nodiscard]] double harm(std::span<const std::uint32_t> triangles) const;

  [[nodiscard]] double badness(std::span<const std::uint32_t> triangles) const;
  [[nodiscard]] std::vector<Refinement::Place> places() const;
  void restore(const std::vector<Refinement::Place>& places);
  [[nodiscard]] std::span<const std::uint32_t> ring(std::size_t i) const {
    return std::span(ring_).subspan(start_[i], start_[i + 1] - start_[i]);
  }
  [[nodiscard]] std::span<const std::uint32_t> around(std::size_t i) const {
    return std::span(around_).subspan(start_[i], start_[i + 1] - start_[i]);
  }

  Refinement& mesh_;
  const Topology& topology_;
  int level_;
  Movable movable_;
  std::size_t moves_left_ = 0, tries_left_ = 0;
  // The patch: vertices that may move, with the triangles and the neighbours of each; all
  // triangles that have one of them.
  std::vector<std::uint32_t> vertices_, around_, ring_, triangles_;
  std::vector<std::size_t> start_;
  std::vector<std::uint32_t> faces_;  // room to work in
  std::vector<SurfacePoint> places_;  // where a vertex might go
  std::vector<Refinement::Place> best_;
  double least_ = 0;
};

/// Vertices whose old place does no harm go back to it.
template <class BadnessAt>
void PatchUnfolder::give_back(const std::vector<Refinement::Place>& before,
                              const BadnessAt& badness_at) {
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const std::uint32_t v = vertices_[i];
    if (mesh_.positions[v] == before[i].at) continue;
    const Refinement::Place now = mesh_.place(v);
    const double bad = badness_at(i);
    mesh_.put(v, before[i]);
    if (badness_at(i) > bad) mesh_.put(v, now);
  }
}

}  // namespace nacre::remesh
