// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/manifest.h"

#include <gtest/gtest.h>

#include "scratch.h"

namespace nacre::app::batch {
namespace {

class Manifests : public testing::Test {
 protected:
  Result<Manifest> read(const std::string& text) {
    scratch.write("m.jsonl", text);
    return read_manifest(scratch.file("m.jsonl"));
  }
  app::test::Scratch scratch;
  const std::string head =
      R"({"schema":"nacre-batch-manifest/0","input_root":"/in","output_root":"/out"})"
      "\n";
};

TEST_F(Manifests, ComeBackAsTheyWere) {
  Manifest manifest{"/in", "/out", {}};
  manifest.items.push_back({"a \"b\".ply", "a \"b\".ncr", {"--size", "6k"}, 100, 7, true});
  manifest.items.push_back({"sub/ä.obj", "sub/ä.ncr", {}, 0, 0, false});
  const Result<Manifest> back = read(to_json_lines(manifest));
  ASSERT_TRUE(back.has_value()) << back.error().message;
  EXPECT_EQ(back->items, manifest.items);
  EXPECT_EQ(back->input_root, "/in");
  EXPECT_EQ(output_path(*back, back->items[1]), "/out/sub/ä.ncr");
  EXPECT_EQ(scan_path(*back, back->items[0]), "/in/a \"b\".ply");
}

TEST_F(Manifests, NeverCrashOnATornOrHostileFile) {
  Manifest manifest{"/in", "/out", {}};
  manifest.items.push_back({"a.ply", "a.ncr", {"--size", "6k"}, 100, 7, true});
  const std::string whole = to_json_lines(manifest);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Result<Manifest> cut = read(whole.substr(0, size));
    if (cut) {
      EXPECT_TRUE(size + 1 == whole.size() || cut->items.empty()) << size;
    } else {
      EXPECT_EQ(cut.error().code, ErrorCode::kUnreadableFile);
    }
  }
}

TEST_F(Manifests, WrongLinesAreNamed) {
  const auto refused = [&](const std::string& line) {
    const Result<Manifest> result = read(head + line + "\n");
    EXPECT_FALSE(result.has_value()) << line;
    if (result) return;
    EXPECT_EQ(result.error().code, ErrorCode::kUnreadableFile);
    EXPECT_NE(result.error().message.find("m.jsonl: line 2: "), std::string::npos)
        << result.error().message;
  };
  refused("[]");
  refused("{}");
  refused(R"({"scan":1,"output":"a.ncr"})");
  refused(R"({"scan":"","output":"a.ncr"})");
  refused(R"({"scan":"a.ply","output":"../a.ncr"})");
  refused(R"({"scan":"a.ply","output":"x/../../a.ncr"})");
  refused(R"({"scan":"a.ply","output":"/etc/a.ncr"})");
  refused(R"({"scan":"a.ply","output":"a.ply"})");
  refused(R"({"scan":"a.ply","output":"a.ncr","options":"--size"})");
  refused(R"({"scan":"a.ply","output":"a.ncr","options":[1]})");
  const std::string twice = R"({"scan":"a.ply","output":"a.ncr"})";
  const Result<Manifest> result = read(head + twice + "\n" + twice + "\n");
  ASSERT_FALSE(result.has_value());
  EXPECT_NE(result.error().message.find("line 3"), std::string::npos);
  EXPECT_FALSE(read(R"({"schema":"nacre-batch-manifest/9"})").has_value());
  EXPECT_FALSE(read("").has_value());
  EXPECT_FALSE(read_manifest(scratch.file("none")).has_value());
  EXPECT_FALSE(read_manifest(scratch.folder()).has_value());
}

}  // namespace
}  // namespace nacre::app::batch
