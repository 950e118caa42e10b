// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a user does wrong, and what the world does wrong, each with the built command: the exit
// code, one line that names the file, and nothing left in the folder.
#include <gtest/gtest.h>

#include <algorithm>

#include "run_command.h"

namespace nacre::app::test {
namespace {

class Refusal : public testing::Test {
 protected:
  /// Runs it, and expects this exit code, one line with `named` in it, and no new file.
  void expect_refused(int exit_code, const std::string& named,
                      const std::vector<std::string>& arguments) {
    const auto before = scratch.listing();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(outcome.err.starts_with("nacre: ")) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with("\n"));
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
    EXPECT_EQ(scratch.listing(), before);
  }

  /// The same for encoding this file's text.
  void expect_scan_refused(int exit_code, const std::string& name, const std::string& text) {
    scratch.write(name, text);
    expect_refused(exit_code, name, {"encode", path(name), "-o", path("out.ncr")});
    expect_refused(exit_code, name, {"remesh", path(name), "-o", path("out.ply")});
  }

  /// The same for decoding this damaged stream; one place in it is named.
  void expect_stream_refused(const std::string& name, const std::string& bytes,
                             const std::string& words) {
    scratch.write(name, bytes);
    expect_refused(7, name, {"decode", path(name), "-o", path("out.ply")});
    const std::string message = run({"decode", path(name), "-o", path("out.ply")}).err;
    EXPECT_NE(message.find(words), std::string::npos) << message;
    const std::size_t place = message.find("(byte ");
    EXPECT_NE(place, std::string::npos) << message;
    EXPECT_EQ(message.find("(byte ", place + 1), std::string::npos) << message;
  }

  [[nodiscard]] std::string path(const std::string& name) const {
    return scratch.file(name).string();
  }

  Scratch scratch;
};

std::string ply(const std::string& vertices, int vertex_count, const std::string& faces,
                int face_count) {
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertex_count) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(face_count) + "\nproperty list uchar int vertex_indices\nend_header\n" +
         vertices + faces;
}

constexpr const char* kTetrahedron = "1 1 1\n1 -1 -1\n-1 1 -1\n-1 -1 1\n";
constexpr const char* kTetrahedronFaces = "3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n";

TEST_F(Refusal, MissingFile) {
  for (const char* name : {"no.ply", "no.ncr", "no"}) {
    expect_refused(3, name, {"info", path(name)});
    expect_refused(3, name, {"compare", path(name), path(name)});
  }
  expect_refused(3, "no.ply", {"encode", path("no.ply"), "-o", path("out.ncr")});
  expect_refused(3, "no.ncr", {"decode", path("no.ncr"), "-o", path("out.ply")});
}

TEST_F(Refusal, FolderInsteadOfFile) {
  std::filesystem::create_directory(scratch.file("dir.ply"));
  expect_refused(3, "dir.ply", {"encode", path("dir.ply"), "-o", path("out.ncr")});
}

TEST_F(Refusal, TextFileNamedPly) {
  expect_scan_refused(3, "notes.ply", "Dear diary,\ntoday I scanned a horse.\n");
}

TEST_F(Refusal, UnknownFormat) { expect_scan_refused(3, "notes.txt", "Dear diary\n"); }

TEST_F(Refusal, EmptyFile) { expect_scan_refused(3, "empty.ply", ""); }

TEST_F(Refusal, CoordinateThatIsNotANumber) {
  expect_scan_refused(3, "nan.ply",
                      ply("1 1 1\n1 nan -1\n-1 1 -1\n-1 -1 1\n", 4, kTetrahedronFaces, 4));
}

TEST_F(Refusal, FaceIndexOutOfRange) {
  expect_scan_refused(3, "index.ply", ply(kTetrahedron, 4, "3 0 1 2\n3 0 3 4\n", 2));
  expect_scan_refused(3, "negative.ply", ply(kTetrahedron, 4, "3 0 1 -2\n", 1));
}

TEST_F(Refusal, ScanCutShort) {
  expect_scan_refused(3, "cut.ply", ply(kTetrahedron, 4, "3 0 1 2\n", 4));
}

TEST_F(Refusal, MeshWithoutSurface) {
  expect_scan_refused(3, "points.ply", ply(kTetrahedron, 4, "", 0));
  expect_scan_refused(3, "nothing.ply", ply("", 0, "", 0));
  expect_scan_refused(4, "needle.ply", ply("0 0 0\n1 0 0\n2 0 0\n", 3, "3 0 1 2\n", 1));
}

TEST_F(Refusal, ScanThatNeedsRepairUnderStrictPolicies) {
  // Two tetrahedra that share an edge: four faces there.
  scratch.write("fin.ply",
                ply(std::string(kTetrahedron) + "3 1 1\n3 -1 -1\n", 6,
                    std::string(kTetrahedronFaces) + "3 0 4 1\n3 0 1 5\n3 0 5 4\n3 1 4 5\n", 8));
  for (const char* policy : {"strict", "none"}) {
    expect_refused(4, "fin.ply",
                   {"encode", path("fin.ply"), "-o", path("out.ncr"), "--repair", policy});
  }
}

TEST_F(Refusal, ImpossibleSize) {
  save(scratch, "sphere.ply", shapes::sphere(3));
  expect_refused(5, "sphere.ply",
                 {"encode", path("sphere.ply"), "-o", path("out.ncr"), "--size", "10", "-q"});
  expect_refused(
      5, "sphere.ply",
      {"encode", path("sphere.ply"), "-o", path("out.ncr"), "--bits-per-vertex", "0.000001", "-q"});
}

TEST_F(Refusal, OutputExists) {
  save(scratch, "sphere.ply", shapes::sphere(2));
  scratch.write("there.ncr", "precious");
  scratch.write("there.json", "precious");
  scratch.write("there.ply", "precious");
  const std::string scan = path("sphere.ply");
  expect_refused(2, "there.ncr", {"encode", scan, "-o", path("there.ncr")});
  expect_refused(2, "there.json",
                 {"encode", scan, "-o", path("new.ncr"), "--report", path("there.json")});
  expect_refused(2, "there.ply", {"decode", path("any.ncr"), "-o", path("there.ply")});
  expect_refused(2, "there.ply", {"remesh", scan, "-o", path("there.ply")});
  expect_refused(2, "there.ply", {"compare", scan, scan, "--map", path("there.ply")});
  for (const char* name : {"there.ncr", "there.json", "there.ply"}) {
    EXPECT_EQ(scratch.read(name), "precious");
  }
}

TEST_F(Refusal, OutputIsTheInputWhateverTheForce) {
  save(scratch, "sphere.ply", shapes::sphere(2));
  const std::string scan = path("sphere.ply"), before = scratch.read("sphere.ply");
  expect_refused(2, "sphere.ply", {"remesh", scan, "-o", scan, "-f"});
  expect_refused(2, "sphere.ply", {"compare", scan, scan, "--map", scan, "-f"});
  EXPECT_EQ(scratch.read("sphere.ply"), before);
}

TEST_F(Refusal, OutputOfUnknownFormat) {
  save(scratch, "sphere.ply", shapes::sphere(2));
  const std::string scan = path("sphere.ply");
  expect_refused(2, "out.zip", {"encode", scan, "-o", path("out.zip")});
  expect_refused(2, "out.step", {"decode", path("any.ncr"), "-o", path("out.step")});
  expect_refused(2, "out", {"remesh", scan, "-o", path("out")});
  expect_refused(2, "r.txt", {"encode", scan, "-o", path("out.ncr"), "--report", path("r.txt")});
  expect_refused(2, "m.obj", {"compare", scan, scan, "--map", path("m.obj")});
  expect_refused(2, "p.jpg", {"compare", scan, scan, "--picture", path("p.jpg")});
}

TEST_F(Refusal, FolderThatCannotBeWritten) {
  save(scratch, "sphere.ply", shapes::sphere(2));
  const std::string scan = path("sphere.ply");
  expect_refused(1, "no/out.ncr", {"encode", scan, "-o", path("no/out.ncr")});
  expect_refused(1, "no/out.ply", {"decode", path("any.ncr"), "-o", path("no/out.ply")});
  expect_refused(1, "sphere.ply/out.ncr", {"encode", scan, "-o", path("sphere.ply/out.ncr")});
  if (geteuid() == 0) return;  // root may write anywhere
  std::filesystem::create_directory(scratch.file("locked"));
  std::filesystem::permissions(scratch.file("locked"), std::filesystem::perms::owner_read |
                                                           std::filesystem::perms::owner_exec);
  expect_refused(1, "locked/out.ncr", {"encode", scan, "-o", path("locked/out.ncr")});
}

TEST_F(Refusal, WrongCommandLine) {
  expect_refused(2, "encode", {"encod", "a", "-o", "b"});
  expect_refused(2, "--help", {});
  expect_refused(2, "--size", {"encode", "a", "-o", "b.ncr", "--sise", "4"});
  expect_refused(2, "SCAN", {"encode"});
}

TEST_F(Refusal, FileThatIsNoStream) {
  scratch.write("text.ncr", "this is no nacre file, but long enough to have a header of one");
  scratch.write("empty.ncr", "");
  for (const char* name : {"text.ncr", "empty.ncr"}) {
    expect_refused(7, name, {"decode", path(name), "-o", path("out.ply")});
    expect_refused(7, name, {"info", path(name)});
    expect_refused(7, name, {"compare", path(name), path(name)});
  }
}

TEST_F(Refusal, StreamCutShortOrDamaged) {
  save(scratch, "sphere.ply", shapes::sphere(3));
  const Outcome good = run({"encode", path("sphere.ply"), "-o", path("good.ncr"), "--size", "1k",
                            "--samples", "1000", "-q"});
  ASSERT_EQ(good.exit_code, 0) << good.err;
  const std::string whole = scratch.read("good.ncr");
  // The codec's own tests try every byte; here a few say that the command passes it on.
  for (std::size_t part = 1; part < 6; ++part) {
    expect_stream_refused("cut.ncr", whole.substr(0, whole.size() * part / 6), "the stream is cut");
    std::string damaged = whole;
    damaged[whole.size() * part / 6] ^= static_cast<char>(1 << part);
    expect_stream_refused("flip.ncr", damaged, "checksum");
  }
  expect_stream_refused("header.ncr", whole.substr(0, 9), "the header is cut");
  expect_stream_refused("more.ncr", whole + "trailing bytes", "bytes after the stream's end");
  expect_refused(2, "good.ncr",
                 {"decode", path("good.ncr"), "-o", path("out.ply"), "--level", "29"});
}

TEST_F(Refusal, InterruptLeavesNothingBehind) {
  save(scratch, "sphere.ply", shapes::sphere(6));
  const auto before = scratch.listing();
  Running encode({"encode", path("sphere.ply"), "-o", path("out.ncr")});
  ASSERT_TRUE(encode.wait_until_interruptible());
  encode.interrupt();
  const Outcome outcome = encode.wait();
  EXPECT_EQ(outcome.exit_code, 75) << outcome.err;
  EXPECT_EQ(scratch.listing(), before);
}

}  // namespace
}  // namespace nacre::app::test
