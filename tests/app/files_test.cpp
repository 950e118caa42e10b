// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/files.h"

#include <gtest/gtest.h>

#include <fstream>

#include "scratch.h"
#include "support/shapes.h"

namespace nacre::app {
namespace {

TEST(ErrorInFile, IsOneLineThatNamesTheFileOnce) {
  const Error named = in_file({ErrorCode::kUnreadableFile, "line 3:\nnot a number"}, "a/scan.ply");
  EXPECT_EQ(named.message, "a/scan.ply: line 3: not a number");
  EXPECT_EQ(in_file(named, "a/scan.ply").message, named.message);
}

TEST(StreamError, SaysWhichByte) {
  const Error error = stream_error({ErrorCode::kCorruptStream, "checksum differs", 120}, "a.ncr");
  EXPECT_EQ(error.message, "a.ncr: checksum differs (byte 120)");
}

TEST(StreamError, SaysWhichByteOnce) {
  const Error error =
      stream_error({ErrorCode::kCorruptStream, "the stream is cut (byte 12)", 12}, "a.ncr");
  EXPECT_EQ(error.message, "a.ncr: the stream is cut (byte 12)");
}

TEST(Extension, IgnoresCase) {
  EXPECT_TRUE(is_stream_name("a.ncr"));
  EXPECT_TRUE(is_stream_name("a/b.NCR"));
  EXPECT_FALSE(is_stream_name("a.ncr.ply"));
  EXPECT_FALSE(is_stream_name("ncr"));
  EXPECT_TRUE(has_extension("x.PnG", ".png"));
}

TEST(CheckOutput, AcceptsANewFileAndRefusesTheRest) {
  const test::Scratch scratch;
  const auto input = scratch.file("in.ply"), there = scratch.file("there.ncr");
  scratch.write("in.ply", "x");
  scratch.write("there.ncr", "x");
  EXPECT_TRUE(check_output(scratch.file("new.ncr"), false, input).has_value());
  EXPECT_TRUE(check_output(there, true, input).has_value());
  EXPECT_EQ(check_output(there, false, input).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(check_output(input, true, input).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(check_output(scratch.folder(), true, input).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(check_output(scratch.file("no/new.ncr"), false, input).error().code,
            ErrorCode::kCannotWrite);
  EXPECT_EQ(check_output(scratch.file("in.ply/new.ncr"), false, input).error().code,
            ErrorCode::kCannotWrite);
  EXPECT_TRUE(check_output_named(scratch.file("r.JSON"), ".json", false, input).has_value());
  EXPECT_EQ(check_output_named(scratch.file("r.txt"), ".json", false, input).error().code,
            ErrorCode::kBadInput);
}

TEST(CheckOutput, SeesADanglingLinkAsThere) {
  const test::Scratch scratch;
  std::filesystem::create_symlink(scratch.file("nowhere"), scratch.file("link.ncr"));
  EXPECT_FALSE(check_output(scratch.file("link.ncr"), false, "in.ply").has_value());
}

TEST(WriteOutput, DoesNotOverwriteUnasked) {
  const test::Scratch scratch;
  const auto file = scratch.file("out.json");
  ASSERT_TRUE(write_output(file, std::string_view("first"), false).has_value());
  const Result<void> again = write_output(file, std::string_view("second"), false);
  ASSERT_FALSE(again.has_value());
  EXPECT_EQ(again.error().code, ErrorCode::kBadInput);
  EXPECT_EQ(scratch.read("out.json"), "first");
  ASSERT_TRUE(write_output(file, std::string_view("second"), true).has_value());
  EXPECT_EQ(scratch.read("out.json"), "second");
}

SemiRegularMesh split_octahedron(int levels) {
  const Scan sphere = shapes::sphere(levels);
  SemiRegularMesh mesh;
  mesh.base_triangles = shapes::octahedron().triangles;
  mesh.base_vertex_count = 6;
  mesh.level_count = levels;
  mesh.positions = sphere.positions;
  mesh.origin = {1, 2, 3};
  return mesh;
}

TEST(ToTriangles, GivesEveryLevelAsAPrefix) {
  const SemiRegularMesh mesh = split_octahedron(3);
  for (int level = 0; level <= 3; ++level) {
    const Result<TriangleMesh> triangles = to_triangles(mesh, level);
    ASSERT_TRUE(triangles.has_value());
    const Scan expected = shapes::sphere(level);
    EXPECT_EQ(triangles->triangles, expected.triangles);
    EXPECT_EQ(triangles->positions, expected.positions);
    EXPECT_EQ(triangles->origin, mesh.origin);
  }
  EXPECT_EQ(to_triangles(mesh)->triangles.size(), 8u << 6);
  EXPECT_EQ(to_triangles(mesh, 9)->triangles.size(), 8u << 6);
}

TEST(ToTriangles, RefusesTooFewPositions) {
  SemiRegularMesh mesh = split_octahedron(2);
  mesh.positions.pop_back();
  EXPECT_FALSE(to_triangles(mesh).has_value());
}

TEST(HasArea, NeedsOneGoodFace) {
  Scan scan{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 1, 3}}, Vec3::Zero()};
  EXPECT_FALSE(has_area(scan));
  EXPECT_FALSE(has_area({}));
  scan.triangles.push_back({0, 1, 3});
  EXPECT_TRUE(has_area(scan));
}

TEST(BoundingBox, LeavesOutVerticesWithoutAFace) {
  Scan scan = shapes::octahedron();
  scan.positions.emplace_back(100, 100, 100);
  const Box box = bounding_box(scan);
  EXPECT_EQ(box.low, Vec3(-1, -1, -1));
  EXPECT_EQ(box.high, Vec3(1, 1, 1));
  EXPECT_DOUBLE_EQ(bbox_diagonal(scan), std::sqrt(12.0));
  EXPECT_EQ(bbox_diagonal({}), 0);
}

}  // namespace
}  // namespace nacre::app
