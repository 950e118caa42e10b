// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/scan_size.h"

#include <gtest/gtest.h>

#include "run_command.h"

namespace nacre::app::batch {
namespace {

class ScanSizes : public testing::Test {
 protected:
  ScanSize size_of(const std::string& name, const std::string& bytes) {
    scratch.write(name, bytes);
    return scan_size(scratch.file(name));
  }
  app::test::Scratch scratch;
};

TEST_F(ScanSizes, HeadersSayTheTriangles) {
  const Scan scan = shapes::sphere(3);
  for (const char* name : {"a.ply", "a.off", "a.stl"}) {
    app::test::save(scratch, name, scan);
    const ScanSize size = scan_size(scratch.file(name));
    EXPECT_EQ(size.triangles, scan.triangles.size()) << name;
    EXPECT_TRUE(size.from_header) << name;
    EXPECT_EQ(size.file_bytes, scratch.read(name).size()) << name;
  }
}

TEST_F(ScanSizes, WhatHasNoHeaderIsGuessedFromItsBytes) {
  const Scan scan = shapes::sphere(5);
  app::test::save(scratch, "a.obj", scan);
  const ScanSize size = scan_size(scratch.file("a.obj"));
  EXPECT_FALSE(size.from_header);
  const double ratio =
      static_cast<double>(size.triangles) / static_cast<double>(scan.triangles.size());
  EXPECT_GT(ratio, 0.4);
  EXPECT_LT(ratio, 2.5);
}

TEST_F(ScanSizes, CountsThatTheFileIsTooShortForAreNotBelieved) {
  const ScanSize ply = size_of("a.ply", "ply\nformat ascii 1.0\nelement face 99999999999\n");
  EXPECT_FALSE(ply.from_header);
  EXPECT_LT(ply.triangles, 100u);
  EXPECT_LT(size_of("a.off", "OFF\n3 18446744073709551615 0\n").triangles, 100u);
  EXPECT_LT(size_of("b.off", "OFF\n3 x 0\n").triangles, 100u);
  EXPECT_LT(size_of("a.stl", std::string(84, '\xff')).triangles, 100u);
}

TEST_F(ScanSizes, UnreadableAndEmptyFilesAreOfSizeZero) {
  EXPECT_EQ(scan_size(scratch.file("none.ply")).triangles, 0u);
  EXPECT_EQ(scan_size(scratch.folder()).triangles, 0u);
  EXPECT_EQ(size_of("empty.ply", "").triangles, 0u);
}

}  // namespace
}  // namespace nacre::app::batch
