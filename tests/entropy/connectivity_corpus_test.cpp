// SPDX-License-Identifier: GPL-3.0-or-later
//
// What base meshes of real scans cost. CGAL's edge collapse makes the bases, so that the figures do
// not move with our own remesher.
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "entropy/connectivity.h"
#include "tests/support/corpus.h"

namespace nacre::entropy {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace pmp = CGAL::Polygon_mesh_processing;
namespace sms = CGAL::Surface_mesh_simplification;

/// Stops at a number of edges that goes down as bases get coarser.
struct EdgeCountStop {
  std::size_t edges;
  bool operator()(const Kernel::FT&, const sms::Edge_profile<Mesh>&, std::size_t,
                  std::size_t current) const {
    return current <= edges;
  }
};

void simplify(Mesh& mesh, std::size_t vertices) {
  // A collapse takes three edges, or two on the boundary, so an open mesh needs some rounds.
  for (int round = 0; round < 4 && mesh.number_of_vertices() > vertices; ++round) {
    const std::size_t surplus = mesh.number_of_vertices() - vertices;
    const EdgeCountStop stop{mesh.number_of_edges() - 3 * surplus};
    sms::GarlandHeckbert_plane_policies<Mesh, Kernel> policies(mesh);
    sms::edge_collapse(mesh, stop,
                       CGAL::parameters::get_cost(policies.get_cost())
                           .get_placement(policies.get_placement())
                           .filter(sms::Bounded_normal_change_filter<>()));
    mesh.collect_garbage();
  }
}

Mesh largest_piece(const std::filesystem::path& path) {
  std::vector<Kernel::Point_3> points;
  std::vector<std::vector<std::size_t>> faces;
  EXPECT_TRUE(CGAL::IO::read_polygon_soup(path.string(), points, faces));
  pmp::repair_polygon_soup(points, faces);
  pmp::orient_polygon_soup(points, faces);
  Mesh mesh;
  pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
  pmp::keep_largest_connected_components(mesh, 1);
  mesh.collect_garbage();
  return mesh;
}

struct Cost {
  double vertices, connectivity_bits, position_bits;  // bits per base vertex
};

/// Codes connectivity and positions on a grid of 12 bits, checks both round trips.
Cost code(const Mesh& mesh) {
  std::vector<Triangle> triangles;
  for (const auto face : mesh.faces()) {
    Triangle t;
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
      t[k++] = static_cast<std::uint32_t>(v.idx());
    triangles.push_back(t);
  }
  const auto count = static_cast<std::uint32_t>(mesh.number_of_vertices());
  const auto encoded = encode_connectivity(triangles, count);
  EXPECT_TRUE(encoded.has_value());
  if (!encoded) return {};
  const auto decoded =
      decode_connectivity(encoded->bytes, static_cast<std::uint32_t>(triangles.size()));
  EXPECT_TRUE(decoded.has_value() && decoded->triangles == encoded->decoded.triangles);
  const auto canonical = [](std::vector<Triangle> list, const std::vector<std::uint32_t>* order) {
    for (Triangle& t : list) {
      if (order != nullptr)
        for (std::uint32_t& v : t) v = order->at(v);
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    }
    std::sort(list.begin(), list.end());
    return list;
  };
  EXPECT_EQ(canonical(encoded->decoded.triangles, &encoded->vertex_order),
            canonical(triangles, nullptr));

  CGAL::Bbox_3 box;
  for (const auto v : mesh.vertices()) box += mesh.point(v).bbox();
  const double side =
      std::max({box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin()});
  std::vector<GridPoint> points;
  for (const std::uint32_t v : encoded->vertex_order) {
    const Kernel::Point_3& p = mesh.point(Mesh::Vertex_index(v));
    GridPoint g;
    for (int k = 0; k < 3; ++k)
      g[static_cast<std::size_t>(k)] =
          static_cast<std::int32_t>(std::lround((p[k] - box.min(k)) / side * 4095.0));
    points.push_back(g);
  }
  const auto bytes = encode_base_positions(points, encoded->decoded, 12);
  const auto read = decode_base_positions(bytes, encoded->decoded, 12);
  EXPECT_TRUE(read.has_value() && *read == points);
  const double bits = 8.0 / count;
  return {static_cast<double>(count), bits * static_cast<double>(encoded->bytes.size()),
          bits * static_cast<double>(bytes.size())};
}

struct Bound {
  const char* file;
  double connectivity_bits, position_bits;  // most allowed at 200 vertices
};

class BaseOfScan : public ::testing::TestWithParam<Bound> {};

TEST_P(BaseOfScan, CostsLittle) {
  const Bound bound = GetParam();
  NACRE_SKIP_WITHOUT(bound.file);
  Mesh mesh = largest_piece(corpus::mesh(bound.file));
  for (const std::size_t vertices : {1000u, 400u, 200u, 100u, 50u}) {
    simplify(mesh, vertices);
    const Cost cost = code(mesh);
    std::cout << bound.file << ": " << cost.vertices << " vertices, connectivity "
              << cost.connectivity_bits << ", positions " << cost.position_bits
              << " bits per base vertex\n";
    if (vertices == 200) {
      EXPECT_LE(cost.connectivity_bits, bound.connectivity_bits);
      EXPECT_LE(cost.position_bits, bound.position_bits);
      // Far better than ever measured: the bound has gone slack.
      EXPECT_GE(cost.connectivity_bits, bound.connectivity_bits - 1.3);
    }
  }
}

// The closed ones are the promise: 3 bits. Open ones pay for their boundary loops.
INSTANTIATE_TEST_SUITE_P(Corpus, BaseOfScan,
                         ::testing::Values(Bound{"horse.ply", 3, 30}, Bound{"venus.off", 3, 30},
                                           Bound{"igea.ply", 3, 30}, Bound{"elephant.off", 3, 30},
                                           Bound{"rockerarm.ply", 3, 30},
                                           Bound{"bunny.ply", 3.6, 30}, Bound{"mask.off", 3, 30},
                                           Bound{"doll_face.obj", 4, 30},
                                           Bound{"fandisk.obj", 3, 30}),
                         [](const auto& bound) {
                           const std::string name = bound.param.file;
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace nacre::entropy
