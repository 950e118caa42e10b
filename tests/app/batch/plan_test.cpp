// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>

#include "run_command.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class Plans : public testing::Test {
 protected:
  Plans() {
    for (const char* folder : {"in/busts/old", "in/parts", "in/.hidden"}) {
      fs::create_directories(scratch.file(folder));
    }
    for (const char* file : {"in/a.ply", "in/busts/b.PLY", "in/busts/old/c.obj", "in/parts/d.stl",
                             "in/.hidden/e.ply", "in/.f.ply", "in/notes.txt"}) {
      app::test::save(scratch, "x.ply", shapes::tetrahedron());
      fs::copy(scratch.file("x.ply"), scratch.file(file));
    }
    command.source = scratch.file("in");
    command.manifest = scratch.file("m.jsonl");
  }
  Result<Manifest> plan() {
    Console console(Verbosity::kQuiet, cancel);
    return make_plan(command, console);
  }
  Words scans() {
    Words names;
    const auto manifest = plan();
    EXPECT_TRUE(manifest.has_value()) << manifest.error().message;
    if (manifest) {
      for (const Item& item : manifest->items) names.push_back(item.scan);
    }
    std::ranges::sort(names);
    return names;
  }
  app::test::Scratch scratch;
  std::atomic<bool> cancel{false};
  PlanCommand command;
};

TEST_F(Plans, MirrorTheFolder) {
  const auto manifest = plan();
  ASSERT_TRUE(manifest.has_value()) << manifest.error().message;
  EXPECT_EQ(manifest->input_root, fs::canonical(scratch.file("in")));
  EXPECT_EQ(manifest->output_root, fs::canonical(scratch.folder()) / "ncr");
  ASSERT_EQ(manifest->items.size(), 4u);
  EXPECT_EQ(manifest->items[0].output, "a.ncr");
  EXPECT_EQ(manifest->items[1].output, "busts/b.ncr");
  EXPECT_EQ(manifest->items[2].output, "busts/old/c.ncr");
  EXPECT_EQ(manifest->items[3].output, "parts/d.ncr");
  EXPECT_EQ(manifest->items[0].triangles, 4u);
  EXPECT_TRUE(manifest->items[0].triangles_from_header);
}

TEST_F(Plans, FiltersChoose) {
  command.exclude = {"busts/old/**"};
  EXPECT_EQ(scans(), (Words{"a.ply", "busts/b.PLY", "parts/d.stl"}));
  command.exclude = {};
  command.include = {"*.txt", "parts/*"};
  EXPECT_EQ(scans(), (Words{"notes.txt", "parts/d.stl"}));
  command.include = {"*.xyz"};
  const auto none = plan();
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().code, ErrorCode::kUnreadableFile);
}

TEST_F(Plans, ScansThatWouldShareAnOutputKeepTheirEndings) {
  for (const char* file : {"in/a.obj", "in/a.ply.off"}) {
    fs::copy(scratch.file("x.ply"), scratch.file(file));
  }
  const auto manifest = plan();
  ASSERT_TRUE(manifest.has_value());
  Words outputs;
  for (const Item& item : manifest->items) outputs.push_back(item.output);
  EXPECT_EQ(outputs, (Words{"a.obj.ncr", "a.ply.ncr", "a.ply.off.ncr", "busts/b.ncr",
                            "busts/old/c.ncr", "parts/d.ncr"}));
}

TEST_F(Plans, ListsNameScansAnywhere) {
  scratch.write("list.txt", scratch.file("in/busts/b.PLY").string() + "\r\n\n" +
                                scratch.file("in/busts/old/c.obj").string() + "\n" +
                                scratch.file("in/busts/old/../b.PLY").string() + "\n");
  command.source = scratch.file("list.txt");
  const auto manifest = plan();
  ASSERT_TRUE(manifest.has_value()) << manifest.error().message;
  EXPECT_EQ(manifest->input_root, scratch.file("in/busts"));
  ASSERT_EQ(manifest->items.size(), 2u) << "a scan that is named twice is one scan";
  EXPECT_EQ(manifest->items[0].scan, "b.PLY");
  EXPECT_EQ(manifest->items[1].scan, "old/c.obj");
  scratch.write("list.txt", "\n");
  EXPECT_FALSE(plan().has_value());
  command.source = scratch.file("none");
  EXPECT_FALSE(plan().has_value());
}

TEST_F(Plans, OptionsAreCheckedBeforeAnyWork) {
  command.encode_options = {"--size", "6k"};
  command.rules = {"busts/**=--bits-per-vertex 2", "*.obj=--levels 3"};
  const auto manifest = plan();
  ASSERT_TRUE(manifest.has_value()) << manifest.error().message;
  EXPECT_EQ(manifest->items[0].options, (Words{"--size", "6k"}));
  EXPECT_EQ(manifest->items[2].options, (Words{"--bits-per-vertex", "2", "--levels", "3"}));
  command.rules = {"*.obj=--levels 99"};
  const auto refused = plan();
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kBadInput);
  EXPECT_NE(refused.error().message.find("c.obj"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace nacre::app::batch
