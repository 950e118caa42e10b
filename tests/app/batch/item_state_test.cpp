// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the output folder remembers, without encoding anything.
#include <gtest/gtest.h>

#include <filesystem>

#include "app/batch/hash.h"
#include "app/batch/record.h"
#include "app/batch/work_folder.h"
#include "scratch.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

class ItemState : public testing::Test {
 protected:
  ItemState() {
    fs::create_directories(scratch.file("out/sub"));
    scratch.write("scan.ply", "the scan");
    manifest = {scratch.folder(), scratch.file("out"), {}};
    item.scan = "scan.ply";
    item.output = "sub/scan.ncr";
    item.options = {"--size", "6k"};
  }
  Record good_record() {
    Record record;
    record.input = *stamp_of(scratch.file("scan.ply"));
    record.input_hash = *hash_file(scratch.file("scan.ply"));
    record.key = content_key(record.input_hash, item.options);
    record.output_bytes = 5;
    record.output_hash = hash_of("coded");
    record.psnr_db = 70.5;
    record.cleaning = {{"welded vertices", 3}};
    record.thumbnail = "AAAA";
    return record;
  }
  void make_done() {
    ASSERT_TRUE(store().write(item, good_record(), scratch.folder()).has_value());
    scratch.write("out/sub/scan.ncr", "coded");
  }
  [[nodiscard]] Store store() const { return Store(scratch.file("out")); }
  [[nodiscard]] State state(bool verify = false, bool read_changed = true) const {
    return state_of(store(), manifest, item, verify, read_changed);
  }
  app::test::Scratch scratch;
  Manifest manifest;
  Item item;
};

TEST_F(ItemState, DoneNeedsRecordAndOutput) {
  EXPECT_EQ(state(), State::kToDo);
  make_done();
  EXPECT_EQ(state(), State::kDone);
  const auto back = store().record(item);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->psnr_db, 70.5);
  EXPECT_EQ(back->cleaning, good_record().cleaning);
  EXPECT_EQ(back->input, good_record().input);
  EXPECT_EQ(back->thumbnail, "AAAA");

  // Killed between the record and the output's name: made again.
  fs::remove(scratch.file("out/sub/scan.ncr"));
  EXPECT_EQ(state(), State::kToDo);
  // The output of earlier options under a record of the new ones: the same.
  scratch.write("out/sub/scan.ncr", "other");
  EXPECT_EQ(state(), State::kToDo);
  // An output that no record knows is somebody else's.
  fs::remove_all(scratch.file("out/.nacre"));
  EXPECT_EQ(state(), State::kForeign);
}

TEST_F(ItemState, TornRecordsCountAsNone) {
  make_done();
  const std::string file = "out/.nacre/records/sub/scan.ncr.json";
  const std::string whole = scratch.read(file);
  for (std::size_t size = 0; size + 2 < whole.size(); size += 7) {
    scratch.write(file, whole.substr(0, size));
    EXPECT_EQ(state(), State::kToDo) << size;
  }
  scratch.write(file, R"({"schema":"nacre-batch-record/0","key":[],"input":3,"output":"x"})");
  EXPECT_EQ(state(), State::kToDo);
}

TEST_F(ItemState, ChangesOfInputOrOptionsMakeItToDo) {
  make_done();
  item.options = {"--size", "7k"};
  EXPECT_EQ(state(), State::kToDo);
  item.options = {"--size", "6k"};
  EXPECT_EQ(state(), State::kDone);

  // Another time but the same bytes: only reading can tell.
  const auto later = fs::last_write_time(scratch.file("scan.ply")) + std::chrono::seconds(5);
  fs::last_write_time(scratch.file("scan.ply"), later);
  EXPECT_EQ(state(false, false), State::kToDo);
  EXPECT_EQ(state(false, true), State::kDone);
  scratch.write("scan.ply", "a longer scan");
  EXPECT_EQ(state(false, true), State::kToDo);

  // Other bytes with the same size and time: only verify tells.
  scratch.write("scan.ply", "the scan");
  const Record record = good_record();
  ASSERT_TRUE(store().write(item, record, scratch.folder()).has_value());
  const auto time = fs::last_write_time(scratch.file("scan.ply"));
  scratch.write("scan.ply", "THE SCAN");
  fs::last_write_time(scratch.file("scan.ply"), time);
  EXPECT_EQ(state(false), State::kDone);
  EXPECT_EQ(state(true), State::kToDo);
}

TEST_F(ItemState, AttemptsCountForTheirInputAndOptionsOnly) {
  Failure failure;
  failure.key = failure_key(*stamp_of(scratch.file("scan.ply")), item.options);
  failure.attempts = 3;
  failure.final = true;
  failure.exit_code = 137;
  failure.signal = 9;
  failure.message = "killed by \"signal\" 9";
  ASSERT_TRUE(store().write(item, failure, scratch.folder()).has_value());
  EXPECT_EQ(state(), State::kFailed);
  EXPECT_EQ(store().failure(item)->message, failure.message);
  EXPECT_EQ(store().failure(item)->signal, 9);
  item.options = {};
  EXPECT_EQ(state(), State::kToDo);
  item.options = {"--size", "6k"};
  scratch.write("scan.ply", "another scan");
  EXPECT_EQ(state(), State::kToDo);
  store().forget_failure(item);
  EXPECT_FALSE(store().failure(item).has_value());
}

TEST_F(ItemState, KeysTellListsOfWordsApart) {
  EXPECT_NE(content_key("h", {"a", "b"}), content_key("h", {"ab"}));
  EXPECT_NE(content_key("h", {"a,1:b"}), content_key("h", {"a", "b"}));
  EXPECT_NE(content_key("h", {}), content_key("g", {}));
  EXPECT_EQ(hash_of(""), "99aa06d3014798d86001c324468d497f");  // xxhsum -H2 /dev/null
}

TEST_F(ItemState, WorkFoldersGoWithTheirProcess) {
  const fs::path below = scratch.file("out/.nacre/work");
  {
    const auto mine = WorkFolder::make(below);
    ASSERT_TRUE(mine.has_value());
    EXPECT_EQ(count_live(below), 1);
    fs::last_write_time(mine->path(), fs::file_time_type::clock::now() - std::chrono::hours(48));
    remove_abandoned(below);
    EXPECT_TRUE(fs::exists(mine->path())) << "locked";
  }
  EXPECT_TRUE(fs::is_empty(below));
  // Left by a killed process of this machine, of another one, of another one long ago.
  char host[256] = {};
  gethostname(host, sizeof(host) - 1);
  const auto leave = [&](const std::string& name, int hours) {
    fs::create_directories(below / name);
    scratch.write("out/.nacre/work/" + name + "/lock", "");
    fs::last_write_time(below / name, fs::file_time_type::clock::now() - std::chrono::hours(hours));
  };
  leave(std::string(host) + "-aaaaaa", 1);
  leave("elsewhere-aaaaaa", 1);
  leave("elsewhere-bbbbbb", 48);
  EXPECT_EQ(count_live(below), 0);
  remove_abandoned(below);
  EXPECT_FALSE(fs::exists(below / (std::string(host) + "-aaaaaa")));
  EXPECT_TRUE(fs::exists(below / "elsewhere-aaaaaa"));
  EXPECT_FALSE(fs::exists(below / "elsewhere-bbbbbb"));
}

}  // namespace
}  // namespace nacre::app::batch
