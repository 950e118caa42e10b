// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/stage.h"

#include <gtest/gtest.h>

#include "app/npy.h"
#include "app/sha256.h"
#include "scratch.h"

namespace nacre::app::test {
namespace {

namespace fs = std::filesystem;

StageRecord example(DumpStage stage) {
  StageRecord record;
  record.stage = stage;
  record.parent = "abc";
  record.key = "key";
  record.options = R"({"levels":3})";
  record.facts = R"({"is_kept":true})";
  record.seconds = 1.5;
  record.peak_bytes = 1000;
  return record;
}

const StageFiles kFiles = {{"a.npy", {1, 2, 3}}, {"scan.ply", {4, 5}}};

class Stage : public testing::Test {
 protected:
  void SetUp() override {
    const auto hash = write_stage(folder, example(DumpStage::kClean), kFiles, false);
    ASSERT_TRUE(hash.has_value()) << hash.error().message;
    hash_ = *hash;
  }
  /// Replaces the first `what` in stage.json.
  void change_record(const std::string& what, const std::string& by) const {
    std::string text = scratch.read("02-clean/stage.json");
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    scratch.write("02-clean/stage.json", text.replace(at, what.size(), by));
  }
  void expect_refused(const std::string& named) const {
    const auto stage = open_stage(folder);
    ASSERT_FALSE(stage.has_value());
    EXPECT_EQ(stage.error().code, ErrorCode::kUnreadableFile);
    EXPECT_NE(stage.error().message.find(named), std::string::npos) << stage.error().message;
  }

  Scratch scratch;
  fs::path folder = scratch.file("02-clean");
  std::string hash_;
};

TEST_F(Stage, ComesBackAsItWasWritten) {
  const auto stage = open_stage(folder);
  ASSERT_TRUE(stage.has_value()) << stage.error().message;
  EXPECT_EQ(stage->record.stage, DumpStage::kClean);
  EXPECT_EQ(stage->record.parent, "abc");
  EXPECT_EQ(stage->record.key, "key");
  EXPECT_EQ(stage->record.options, R"({"levels":3})");
  EXPECT_EQ(stage->record.facts, R"({"is_kept":true})");
  EXPECT_EQ(stage->record.seconds, 1.5);
  EXPECT_EQ(stage->record.peak_bytes, 1000u);
  EXPECT_EQ(stage->files.at("a.npy"), (std::vector<std::uint8_t>{1, 2, 3}));
  EXPECT_TRUE(stage->edited.empty());
  EXPECT_EQ(stage->hash, hash_);
  // The hash is what `sha256sum` makes of the names and hashes.
  EXPECT_EQ(hash_, sha256("a.npy " + sha256(std::string("\1\2\3")) + "\nscan.ply " +
                          sha256(std::string("\4\5")) + "\n"));
}

TEST_F(Stage, NamesWhatWasEdited) {
  scratch.write("02-clean/scan.ply", "\4\6");
  const auto stage = open_stage(folder);
  ASSERT_TRUE(stage.has_value());
  EXPECT_EQ(stage->edited, std::vector<std::string>{"scan.ply"});
  EXPECT_NE(stage->hash, stage->record.hash);
}

TEST_F(Stage, APlyMayBeMissingAnArrayMayNot) {
  fs::remove(folder / "scan.ply");
  const auto stage = open_stage(folder);
  ASSERT_TRUE(stage.has_value());
  EXPECT_TRUE(stage->edited.empty());
  EXPECT_EQ(stage->hash, hash_);
  fs::remove(folder / "a.npy");
  expect_refused("a.npy");
}

TEST_F(Stage, RefusesOtherRecords) {
  change_record("nacre-stage/1", "nacre-stage/2");
  expect_refused("nacre-stage/2");
  scratch.write("02-clean/stage.json", "{");
  expect_refused("stage.json");
  scratch.write("02-clean/stage.json", "[1]");
  expect_refused("is no stage record");
  fs::remove(folder / "stage.json");
  expect_refused("has no stage.json");
}

TEST_F(Stage, RefusesDamagedRecords) {
  change_record("\"clean\"", "\"cleen\"");
  expect_refused("cleen");
  change_record("\"cleen\"", "17");
  expect_refused("lacks an entry");
}

TEST_F(Stage, ReadsNoFileOutsideOfItsFolder) {
  change_record("\"a.npy\"", "\"../secret\"");
  expect_refused("not in its folder");
}

TEST_F(Stage, IsNotOverwrittenUnasked) {
  EXPECT_FALSE(write_stage(folder, example(DumpStage::kClean), kFiles, false).has_value());
  EXPECT_TRUE(write_stage(folder, example(DumpStage::kClean), kFiles, true).has_value());
}

TEST(StageKeys, DependOnAllThatComesBefore) {
  StageKeys a, b;
  for (StageKeys* keys : {&a, &b}) {
    keys->set_origin("scan");
    keys->set_options(DumpStage::kClean, "{}");
    keys->set_options(DumpStage::kSteps, R"({"theta":1})");
  }
  EXPECT_EQ(a.key(DumpStage::kStream), b.key(DumpStage::kStream));
  EXPECT_NE(a.key(DumpStage::kClean), a.key(DumpStage::kBase));
  b.set_options(DumpStage::kSteps, R"({"theta":2})");
  EXPECT_EQ(a.key(DumpStage::kNormalMesh), b.key(DumpStage::kNormalMesh));
  EXPECT_NE(a.key(DumpStage::kSteps), b.key(DumpStage::kSteps));
  EXPECT_NE(a.key(DumpStage::kStream), b.key(DumpStage::kStream));
  b.set_origin("other");
  EXPECT_NE(a.key(DumpStage::kInput), b.key(DumpStage::kInput));
}

}  // namespace
}  // namespace nacre::app::test
