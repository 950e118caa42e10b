// SPDX-License-Identifier: Apache-2.0
#include "entropy/valence_front.h"

#include <algorithm>
#include <bit>

namespace nacre::entropy {
namespace {

// Bucket 0: no slots. Bucket 1: dummies. Then by slots; nodes with very many share the last.
constexpr std::size_t kBucketCount = 34;

}  // namespace

std::size_t ValenceFront::bucket_of(const Node& node) const {
  if (node.slots == 0) return 0;
  if (node.dummy) return 1;
  return std::min<std::size_t>(node.slots + 1, kBucketCount - 1);
}

std::uint64_t ValenceFront::joins_at(const Node& node) const {
  return node.alive && !node.dummy && node.slots >= 2 ? node.slots - 1 : 0;
}

std::uint32_t ValenceFront::create(std::uint32_t vertex, std::uint32_t slots, bool dummy) {
  const auto id = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({vertex, slots, id, id, dummy, true});
  ++alive_count_;
  // Appending to a Fenwick tree: entry i (from 1) holds the sum over (i - lowest bit of i, i].
  const std::size_t i = nodes_.size();
  if (tree_.empty()) tree_.push_back(0);
  std::uint64_t sum = joins_at(nodes_.back());
  for (std::size_t child = 1; child < (i & (~i + 1)); child *= 2) sum += tree_[i - child];
  tree_.push_back(sum);
  if (buckets_.empty()) buckets_.resize(kBucketCount);
  buckets_[bucket_of(nodes_.back())].push_back(id);
  return id;
}

void ValenceFront::set_slots(std::uint32_t node, std::uint32_t slots) {
  Node& n = nodes_[node];
  const std::uint64_t before = joins_at(n);
  n.slots = slots;
  add_weight(node, joins_at(n) - before);
  buckets_[bucket_of(n)].push_back(node);
}

void ValenceFront::remove(std::uint32_t node) {
  add_weight(node, std::uint64_t{0} - joins_at(nodes_[node]));
  nodes_[node].alive = false;
  --alive_count_;
}

void ValenceFront::link(std::uint32_t first, std::uint32_t second) {
  nodes_[first].next = second;
  nodes_[second].previous = first;
}

Triangle ValenceFront::open(const Triangle& vertices, const Triangle& valences,
                            const std::array<bool, 3>& dummies) {
  Triangle ids;
  for (std::size_t k = 0; k < 3; ++k) ids[k] = create(vertices[k], valences[k] - 2, dummies[k]);
  // The front runs the other way around than the triangle it surrounds.
  for (std::size_t k = 0; k < 3; ++k) link(ids[(k + 1) % 3], ids[k]);
  return ids;
}

std::uint32_t ValenceFront::focus() {
  for (std::size_t b = 0; b < kBucketCount; ++b) {
    std::vector<std::uint32_t>& bucket = buckets_[b];
    while (!bucket.empty()) {
      const Node& n = nodes_[bucket.back()];
      if (n.alive && bucket_of(n) == b) return bucket.back();
      bucket.pop_back();
    }
  }
  return kNone;
}

bool ValenceFront::close(std::uint32_t node) {
  const std::uint32_t p = nodes_[node].previous, n = nodes_[node].next;
  const std::uint32_t p_slots = nodes_[p].slots, n_slots = nodes_[n].slots;
  if (nodes_[n].next == p) {
    if (p_slots != 0 || n_slots != 0) return false;
    for (const std::uint32_t id : {p, node, n}) remove(id);
    return true;
  }
  if (p_slots == 0 || n_slots == 0) return false;
  remove(node);
  link(p, n);
  set_slots(p, p_slots - 1);
  set_slots(n, n_slots - 1);
  return true;
}

std::uint32_t ValenceFront::add(std::uint32_t node, std::uint32_t vertex, std::uint32_t valence,
                                bool dummy) {
  const std::uint32_t n = nodes_[node].next;
  if (nodes_[node].slots == 0 || nodes_[n].slots == 0 || valence < 2) return kNone;
  const std::uint32_t x = create(vertex, valence - 2, dummy);
  link(node, x);
  link(x, n);
  set_slots(n, nodes_[n].slots - 1);
  set_slots(node, nodes_[node].slots - 1);
  return x;
}

bool ValenceFront::join(std::uint32_t node, std::uint32_t other, std::uint32_t skipped,
                        Joined& joined) {
  const std::uint32_t n = nodes_[node].next;
  if (nodes_[node].slots == 0 || nodes_[n].slots == 0) return false;
  if (!nodes_[other].alive || nodes_[other].slots < 2 || skipped > nodes_[other].slots - 2)
    return false;
  const std::uint32_t x_previous = nodes_[other].previous;
  if (other == node || other == n || other == nodes_[node].previous || other == nodes_[n].next)
    return false;
  const std::uint32_t rest = nodes_[other].slots - 2 - skipped;
  const std::uint32_t twin = create(nodes_[other].vertex, rest, nodes_[other].dummy);
  set_slots(other, skipped);
  link(x_previous, twin);
  link(twin, n);
  link(node, other);
  set_slots(n, nodes_[n].slots - 1);
  set_slots(node, nodes_[node].slots - 1);
  joined = {other, twin};
  return true;
}

void ValenceFront::add_weight(std::uint32_t node, std::uint64_t change) {
  if (change == 0) return;
  for (std::size_t i = node + 1; i < tree_.size(); i += i & (~i + 1)) tree_[i] += change;
}

std::uint64_t ValenceFront::weight_below(std::uint32_t node) const {
  std::uint64_t sum = 0;
  for (std::size_t i = node; i > 0; i &= i - 1) sum += tree_[i];
  return sum;
}

void ValenceFront::hide_neighbours(std::uint32_t node, bool hide) {
  std::array<std::uint32_t, 4> ids = {node, nodes_[node].next, nodes_[node].previous,
                                      nodes_[nodes_[node].next].next};
  std::sort(ids.begin(), ids.end());
  const auto end = std::unique(ids.begin(), ids.end());
  for (auto id = ids.begin(); id != end; ++id) {
    const std::uint64_t weight = joins_at(nodes_[*id]);
    add_weight(*id, hide ? std::uint64_t{0} - weight : weight);
  }
}

std::uint64_t ValenceFront::join_count(std::uint32_t node) {
  hide_neighbours(node, true);
  const std::uint64_t count = weight_below(static_cast<std::uint32_t>(nodes_.size()));
  hide_neighbours(node, false);
  return count;
}

std::uint64_t ValenceFront::join_index(std::uint32_t node, std::uint32_t other,
                                       std::uint32_t skipped) {
  hide_neighbours(node, true);
  const std::uint64_t index = weight_below(other) + skipped;
  hide_neighbours(node, false);
  return index;
}

ValenceFront::JoinPlace ValenceFront::join_place(std::uint32_t node, std::uint64_t index) {
  hide_neighbours(node, true);
  std::size_t at = 0;
  for (std::size_t step = std::bit_floor(tree_.size()); step > 0; step /= 2) {
    if (at + step < tree_.size() && tree_[at + step] <= index) {
      at += step;
      index -= tree_[at];
    }
  }
  hide_neighbours(node, false);
  return {static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(index)};
}

}  // namespace nacre::entropy
