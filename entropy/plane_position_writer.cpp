// SPDX-License-Identifier: Apache-2.0
#include "entropy/plane_position_writer.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "entropy/plane_positions.h"

namespace nacre::entropy {

struct PlanePositionWriter::Impl {
  Impl(ClosedMesh closed, int grid_bits)
      : mesh(std::move(closed)),
        bits(grid_bits),
        traversal(mesh, grid_bits),
        points(mesh.vertex_count) {}

  ClosedMesh mesh;
  int bits;
  PlaneTraversal traversal;
  std::vector<GridPoint> points;
  mutable PlaneModels models;
  SymbolWriter writer;
  std::uint32_t vertex = kNone;
  Outlook outlook;
};

PlanePositionWriter::PlanePositionWriter(const Connectivity& connectivity, int bits) {
  Result<ClosedMesh> mesh = close_mesh(connectivity.triangles, connectivity.vertex_count);
  assert(mesh.has_value() && bits >= 1 && bits <= 24);
  impl_ = std::make_unique<Impl>(std::move(*mesh), bits);
}
PlanePositionWriter::~PlanePositionWriter() = default;
PlanePositionWriter::PlanePositionWriter(PlanePositionWriter&&) noexcept = default;
PlanePositionWriter& PlanePositionWriter::operator=(PlanePositionWriter&&) noexcept = default;

std::uint32_t PlanePositionWriter::next() {
  impl_->vertex = impl_->traversal.next();
  if (impl_->vertex != kNone)
    impl_->outlook = impl_->traversal.look_out(impl_->vertex, impl_->points);
  return impl_->vertex;
}

const Outlook& PlanePositionWriter::outlook() const { return impl_->outlook; }

bool PlanePositionWriter::can_tell(const PositionChoice& choice, const GridPoint& point) const {
  const Outlook& o = impl_->outlook;
  for (const std::int32_t x : point)
    if (x < 0 || x >= std::int32_t{1} << impl_->bits) return false;
  if (o.plane_count == 0) return true;
  const Plane& plane = o.planes[choice.plane];
  const auto axes = plane_axes(plane.normal);
  const std::size_t f = first_told(choice);
  const auto is_whole = [&](std::size_t axis, int level, std::int64_t expected) {
    return ((point[axis] - expected) & ((std::int64_t{1} << o.shift(level)) - 1)) == 0;
  };
  if (!is_whole(axes[f], choice.levels[f], o.near.point[axes[f]])) return false;
  const bool has_line = choice.levels[1 - f] > 0 && choice.second_plane != kNone;
  return is_whole(axes[1 - f], choice.levels[1 - f],
                  has_line ? solve_line(plane, o.planes[choice.second_plane], axes[f], axes[1 - f],
                                        point, impl_->bits)
                           : o.near.point[axes[1 - f]]);
}

std::uint32_t PlanePositionWriter::cost(const PositionChoice& choice,
                                        const GridPoint& point) const {
  BitPricer pricer;
  PositionChoice told_choice = choice;
  GridPoint told_point = point;
  ToldVertex told;
  PlanePositionCoder<BitPricer> coder(pricer, impl_->models, impl_->bits);
  const bool ok = coder.code(impl_->outlook, told_choice, told_point, told);
  assert(ok);
  static_cast<void>(ok);
  return pricer.cost();
}

PositionChoice PlanePositionWriter::cheapest(const GridPoint& point) const {
  const Outlook& o = impl_->outlook;
  const int finest = o.finest_level();
  PositionChoice best;
  if (o.plane_count == 0) return best;
  std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
  const auto try_choice = [&](const PositionChoice& choice) {
    if (!can_tell(choice, point)) return;
    const std::uint32_t price = cost(choice, point);
    if (price >= least) return;
    least = price;
    best = choice;
  };
  for (std::uint32_t plane = 0; plane < o.plane_count; ++plane) {
    const auto axes = plane_axes(o.planes[plane].normal);
    for (int a = 0; a <= finest; ++a) {
      for (int b = 0; b <= finest; ++b) {
        PositionChoice choice;
        choice.plane = plane;
        choice.levels = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
        try_choice(choice);
        if (std::max(a, b) == 0) continue;
        for (std::uint32_t i = 0; i < o.plane_count; ++i) {
          if (i == plane || !have_line(o.planes[plane], o.planes[i], axes[first_told(choice)]))
            continue;
          choice.second_plane = i;
          try_choice(choice);
        }
      }
    }
  }
  return best;
}

void PlanePositionWriter::write(const GridPoint& point) {
  PositionChoice choice = cheapest(point);
  PlanePositionCoder<SymbolWriter> coder(impl_->writer, impl_->models, impl_->bits);
  GridPoint& told_point = impl_->points[impl_->vertex];
  told_point = point;
  ToldVertex told;
  const bool ok = coder.code(impl_->outlook, choice, told_point, told);
  assert(ok && told_point == point);
  static_cast<void>(ok);
  impl_->traversal.finish(impl_->vertex, told);
}

std::vector<std::uint8_t> PlanePositionWriter::finish() { return impl_->writer.finish(); }

std::vector<std::uint8_t> encode_positions_by_planes(std::span<const GridPoint> points,
                                                     const Connectivity& connectivity, int bits) {
  PlanePositionWriter writer(connectivity, bits);
  for (std::uint32_t v = writer.next(); v != kNone; v = writer.next()) writer.write(points[v]);
  return writer.finish();
}

}  // namespace nacre::entropy
