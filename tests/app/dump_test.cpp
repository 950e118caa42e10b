// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/dump.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "io/io.h"
#include "scratch.h"
#include "support/shapes.h"

namespace nacre::app::test {
namespace {

/// An octahedron split `levels` times as a scan, and the octahedron as its base: a map that is a
/// similarity on every base triangle.
struct FlatMap {
  Scan scan;
  remesh::Parameterisation map;
};

FlatMap flat_octahedron(int levels) {
  const Scan base = shapes::octahedron();
  FlatMap out{shapes::split(base, levels), {}};
  out.map.base.triangles = base.triangles;
  for (std::uint32_t v = 0; v < 6; ++v) out.map.base.scan_vertex.push_back(v);
  for (const Triangle& t : base.triangles) {
    Triangle neighbors{};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::uint32_t g = 0; g < base.triangles.size(); ++g)
        for (std::size_t m = 0; m < 3; ++m)
          if (base.triangles[g][m] == t[(k + 1) % 3] && base.triangles[g][(m + 1) % 3] == t[k])
            neighbors[k] = g;
    out.map.base.neighbors.push_back(neighbors);
  }
  out.map.point.resize(out.scan.positions.size());
  const std::size_t children = out.scan.triangles.size() / base.triangles.size();
  for (std::size_t f = 0; f < out.scan.triangles.size(); ++f) {
    const auto face = static_cast<std::uint32_t>(f / children);
    for (const std::uint32_t v : out.scan.triangles[f]) {
      // In an octahedron's face the weights are the sizes of the coordinates.
      remesh::DomainPoint p{face, {}};
      for (std::size_t k = 0; k < 3; ++k)
        p.weight[k] = base.positions[base.triangles[face][k]].dot(out.scan.positions[v]);
      out.map.point[v] = p;
    }
  }
  return out;
}

SemiRegularMesh ball(int levels) {
  const Scan base = shapes::octahedron();
  return {base.triangles, 6, levels, shapes::sphere(levels).positions, Vec3::Zero()};
}

io::ReadResult read_back(const Scratch& scratch, const DumpMesh& dump) {
  const auto bytes = to_ply(dump);
  EXPECT_TRUE(bytes.has_value()) << bytes.error().message;
  scratch.write("dump.ply", std::string(bytes->begin(), bytes->end()));
  auto read = io::read_scan(scratch.file("dump.ply"));
  EXPECT_TRUE(read.has_value()) << read.error().message;
  return read ? std::move(*read) : io::ReadResult{};
}

TEST(DumpPly, HoldsValuesAndColoursOfVerticesAndFaces) {
  const Scratch scratch;
  DumpMesh dump;
  dump.mesh = shapes::tetrahedron();
  dump.vertex_quality = {0, 1, 2, 3};
  dump.vertex_color.assign(4, Rgb{1, 2, 3});
  dump.face_quality = {5, 6, 7, 8};
  dump.face_color.assign(4, Rgb{9, 8, 7});
  dump.comments = {"what it is"};
  const io::ReadResult read = read_back(scratch, dump);
  EXPECT_EQ(read.scan.triangles, dump.mesh.triangles);
  EXPECT_EQ(read.scan.positions, dump.mesh.positions);
  const std::string bytes = scratch.read("dump.ply");
  EXPECT_NE(bytes.find("comment what it is\n"), std::string::npos);
  const std::size_t header = bytes.find("end_header\n") + 11;
  EXPECT_EQ(bytes.size(), header + 4 * (12 + 4 + 3) + 4 * (1 + 12 + 4 + 3));
  float quality = 0;  // of the last face
  std::memcpy(&quality, bytes.data() + bytes.size() - 7, sizeof quality);
  EXPECT_EQ(quality, 8);
  EXPECT_EQ(bytes.back(), 7);
}

TEST(DumpPly, FarAwayMeshesKeepTheirDigits) {
  const Scratch scratch;
  DumpMesh dump;
  dump.mesh = shapes::tetrahedron();
  dump.mesh.origin = {500'000.25, 4'649'776.5, 120};
  const Scan back = read_back(scratch, dump).scan;
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_EQ(back.positions[v] + back.origin, dump.mesh.positions[v] + dump.mesh.origin);
}

TEST(DumpPly, RefusesWhatDoesNotFit) {
  DumpMesh dump;
  dump.mesh = shapes::tetrahedron();
  dump.vertex_quality = {1, 2, 3};
  EXPECT_EQ(to_ply(dump).error().code, ErrorCode::kBadInput);
  dump.vertex_quality.clear();
  dump.face_color.resize(5);
  EXPECT_EQ(to_ply(dump).error().code, ErrorCode::kBadInput);
  dump.face_color.clear();
  dump.mesh.triangles[2][1] = 4;
  EXPECT_EQ(to_ply(dump).error().code, ErrorCode::kBadInput);
}

TEST(DumpMeshes, AppendShiftsTheTriangles) {
  DumpMesh whole;
  const FlatMap part = flat_octahedron(0);
  append(whole, dump_base(part.scan, part.map, 0));
  append(whole, dump_base(part.scan, part.map, 8));
  EXPECT_EQ(whole.mesh.positions.size(), 12u);
  EXPECT_EQ(whole.mesh.triangles.size(), 16u);
  EXPECT_EQ(whole.mesh.triangles[8][0], whole.mesh.triangles[0][0] + 6);
  EXPECT_EQ(whole.face_color.size(), 16u);
  EXPECT_NE(whole.face_color[0], whole.face_color[8]);
  EXPECT_EQ(whole.vertex_quality, std::vector<float>(12, 4));
  EXPECT_TRUE(to_ply(whole).has_value());
}

/// Most vertices on the sides belong to one of the two triangles: seen from the other they must lie
/// where they do, or triangles at the sides would come out of shape.
TEST(DumpParameterisation, ASimilarityPullsNothingOutOfShape) {
  const FlatMap flat = flat_octahedron(3);
  const DumpMesh dump = dump_parameterisation(flat.scan, flat.map);
  const std::size_t per_base = dump.mesh.triangles.size() / 8;
  EXPECT_GE(per_base, 64u);
  for (std::size_t f = 0; f < dump.mesh.triangles.size(); ++f)
    ASSERT_NEAR(dump.face_quality[f], 1, 1e-6) << f;
  for (std::size_t face = 0; face < 8; ++face) {
    std::map<Rgb, int> colors;  // two of the checkerboard, and the border's
    for (std::size_t i = 0; i < per_base; ++i) ++colors[dump.face_color[face * per_base + i]];
    EXPECT_LE(colors.size(), 3u);
    EXPECT_GE(colors.size(), 2u);
  }
  EXPECT_TRUE(to_ply(dump).has_value());
}

TEST(DumpParameterisation, StretchIsTheRatioOfTheAxes) {
  // A unit triangle, pulled by 3 along one axis.
  const Scan sheet{{{0, 0, 0}, {3, 0, 0}, {1.5, std::sqrt(0.75), 0}}, {{0, 1, 2}}};
  remesh::Parameterisation map;
  map.base.triangles = {{0, 1, 2}};
  map.base.neighbors = {{kNone, kNone, kNone}};
  map.base.scan_vertex = {0, 1, 2};
  map.point = {{0, {1, 0, 0}}, {0, {0, 1, 0}}, {0, {0, 0, 1}}};
  const DumpMesh dump = dump_parameterisation(sheet, map);
  for (const float q : dump.face_quality) EXPECT_NEAR(q, 3, 1e-5);
}

TEST(DumpLevel, MarksVectorsBoundariesAndFolds) {
  const SemiRegularMesh mesh = ball(3);
  std::vector<std::uint8_t> kind(mesh.positions.size(), 0);
  kind[10] = 1;
  kind[11] = 2;
  const auto check = FoldCheck::build(shapes::sphere(4));
  ASSERT_TRUE(check.has_value());
  const auto fine = dump_level(mesh, 3, kind, *check);
  ASSERT_TRUE(fine.has_value());
  EXPECT_EQ(fine->mesh.triangles.size(), 8u * 64);
  EXPECT_EQ(fine->vertex_quality[10], 1);
  EXPECT_EQ(fine->vertex_quality[11], 2);
  EXPECT_EQ(std::ranges::count(fine->face_color, kFoldMagenta), 0);
  EXPECT_EQ(fine->vertex_color[10], kBoundaryBlue);
  EXPECT_EQ(fine->vertex_color[11], kVectorOrange);
  EXPECT_EQ(fine->vertex_color[12], kNormalGrey);

  SemiRegularMesh folded = mesh;  // a vertex across its neighbours
  folded.positions[100] =
      (folded.positions[100] + 0.4 * Vec3(1, 1, 1).cross(folded.positions[100])).normalized();
  const auto marked = dump_level(folded, 3, kind, *check);
  ASSERT_TRUE(marked.has_value());
  EXPECT_GT(std::ranges::count(marked->face_color, kFoldMagenta), 0);
  EXPECT_EQ(marked->vertex_color[100], kFoldMagenta);
  EXPECT_EQ(dump_level(mesh, 3, std::span(kind).first(20), *check).error().code,
            ErrorCode::kBadInput);
}

TEST(FoldCheck, CountsTurnedTrianglesOnly) {
  const Scan fine = shapes::sphere(5);
  const auto check = FoldCheck::build(fine);
  ASSERT_TRUE(check.has_value());
  Scan coarse = shapes::sphere(2);
  EXPECT_EQ(check->check(coarse).folds, 0u);
  std::swap(coarse.triangles[7][0], coarse.triangles[7][1]);
  const FoldCheck::Outcome outcome = check->check(coarse);
  EXPECT_EQ(outcome.folds, 1u);
  EXPECT_EQ(outcome.folded[7], 1);
  coarse.origin = {1, 0, 0};  // the same place, told otherwise
  for (Vec3& p : coarse.positions) p -= coarse.origin;
  EXPECT_EQ(check->check(coarse).folds, 1u);
  EXPECT_NEAR(check->check(coarse).distance[7], outcome.distance[7], 1e-12);
}

/// A thin shell: a coarse triangle's middle lies nearer to the other side. That is no fold.
TEST(FoldCheck, IsNotLedAstrayByThinSheets) {
  Scan outside = shapes::sphere(5), inside = outside;
  for (Vec3& p : inside.positions) p *= 0.97;
  for (Triangle& t : inside.triangles) std::swap(t[1], t[2]);
  const auto check = FoldCheck::build(shapes::joined(outside, inside));
  ASSERT_TRUE(check.has_value());
  const FoldCheck::Outcome outcome = check->check(shapes::sphere(2));
  EXPECT_GT(outcome.opposed, 0u);
  EXPECT_EQ(outcome.folds, 0u);
}

DumpSettings all_of(const std::filesystem::path& folder) {
  DumpSettings settings;
  settings.work_dir = folder;
  settings.stages.fill(true);
  return settings;
}

/// Hands a dumper what a remesher would.
void play(Dumper& dumper) {
  const FlatMap flat = flat_octahedron(2);
  const auto cleaned = remesh::clean(flat.scan);
  ASSERT_TRUE(cleaned.has_value());
  dumper.input(flat.scan);
  const remesh::Observer observer = dumper.observer();
  if (observer.cleaned) observer.cleaned(*cleaned);
  if (observer.base) observer.base(flat.scan, flat.map);
  const SemiRegularMesh mesh = ball(2);
  const std::vector<std::uint8_t> kind(mesh.positions.size(), 0);
  if (observer.normal_mesh) observer.normal_mesh(mesh, kind);
}

TEST(Dumper, WritesAFolderPerStep) {
  const Scratch scratch;
  const std::filesystem::path work = scratch.file("deep/work");
  Dumper dumper(all_of(work), false);
  ASSERT_TRUE(dumper.check().has_value());
  play(dumper);
  const Result<void> done = dumper.finish();
  ASSERT_TRUE(done.has_value()) << done.error().message;
  for (const char* name : {"01-input/scan.ply", "02-clean/clean.ply", "03-base/base.ply",
                           "04-parameterisation/map.ply", "05-normal-mesh/level-0.ply",
                           "05-normal-mesh/level-2.ply"}) {
    EXPECT_TRUE(io::read_scan(work / name).has_value()) << name;
    EXPECT_TRUE(std::filesystem::exists((work / name).parent_path() / "picture.png")) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(work / "05-normal-mesh/level-3.ply"));
}

TEST(Dumper, WritesOnlyWhatIsWanted) {
  const Scratch scratch;
  DumpSettings settings;
  settings.work_dir = scratch.folder();
  settings.stages[static_cast<std::size_t>(DumpStage::kBase)] = true;
  Dumper dumper(settings, false);
  EXPECT_FALSE(dumper.observer().cleaned);
  EXPECT_FALSE(dumper.observer().normal_mesh);
  play(dumper);
  EXPECT_TRUE(dumper.finish().has_value());
  EXPECT_EQ(scratch.listing(), std::set<std::string>{"03-base"});
}

/// A run that fails after the base was chosen has its base to look at.
TEST(Dumper, FinishWritesWhatAFailedRunHad) {
  const Scratch scratch;
  Dumper dumper(all_of(scratch.folder()), false);
  const FlatMap flat = flat_octahedron(1);
  dumper.observer().base(flat.scan, flat.map);
  EXPECT_TRUE(dumper.finish().has_value());
  EXPECT_TRUE(scratch.has("03-base/base.ply"));
  EXPECT_TRUE(scratch.has("04-parameterisation/map.ply"));
}

TEST(Dumper, DoesNotOverwriteUnasked) {
  const Scratch scratch;
  std::filesystem::create_directories(scratch.file("02-clean"));
  EXPECT_TRUE(Dumper(all_of(scratch.folder()), false).check().has_value());
  scratch.write("02-clean/clean.ply", "mine");
  EXPECT_EQ(Dumper(all_of(scratch.folder()), false).check().error().code, ErrorCode::kBadInput);
  EXPECT_TRUE(Dumper(all_of(scratch.folder()), true).check().has_value());
  Dumper dumper(all_of(scratch.folder()), false);
  play(dumper);  // goes on to the end
  EXPECT_FALSE(dumper.finish().has_value());
  EXPECT_EQ(scratch.read("02-clean/clean.ply"), "mine");
  EXPECT_TRUE(scratch.has("05-normal-mesh/level-2.ply"));
}

TEST(Dumper, LeavesNoLevelsOfADeeperRun) {
  const Scratch scratch;
  std::filesystem::create_directories(scratch.file("05-normal-mesh"));
  for (const char* name : {"level-0.ply", "level-3.ply", "level-4.ply", "notes.ply"})
    scratch.write(std::string("05-normal-mesh/") + name, "old");
  DumpSettings settings;
  settings.work_dir = scratch.folder();
  settings.stages[static_cast<std::size_t>(DumpStage::kNormalMesh)] = true;
  Dumper dumper(settings, true);
  play(dumper);
  EXPECT_TRUE(dumper.finish().has_value());
  EXPECT_NE(scratch.read("05-normal-mesh/level-0.ply"), "old");
  EXPECT_FALSE(scratch.has("05-normal-mesh/level-3.ply"));
  EXPECT_FALSE(scratch.has("05-normal-mesh/level-4.ply"));
  EXPECT_TRUE(scratch.has("05-normal-mesh/notes.ply"));
}

TEST(Dumper, SaysWhereItCannotWrite) {
  const Scratch scratch;
  scratch.write("file", "");
  Dumper dumper(all_of(scratch.file("file/work")), false);
  EXPECT_EQ(dumper.check().error().code, ErrorCode::kCannotWrite);
  play(dumper);
  EXPECT_EQ(dumper.finish().error().code, ErrorCode::kCannotWrite);
  EXPECT_TRUE(Dumper({}, false).check().has_value());
  EXPECT_TRUE(Dumper({}, false).finish().has_value());
}

}  // namespace
}  // namespace nacre::app::test
