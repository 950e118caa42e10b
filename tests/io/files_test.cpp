// SPDX-License-Identifier: GPL-3.0-or-later
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <thread>

#include "io/io_test_support.h"

namespace nacre::io {
namespace {

namespace fs = std::filesystem;

void expect_cannot_write(const Result<void>& result, const std::string& part) {
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kCannotWrite);
  EXPECT_NE(result.error().message.find(part), std::string::npos) << result.error().message;
}

std::string content(const fs::path& file) {
  const auto bytes = read_file(file);
  return bytes.has_value() ? text_of(*bytes) : bytes.error().message;
}

TEST(WriteFile, WritesNewFilesAndNothingElse) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "a.ply", bytes_of("one"), false).has_value());
  EXPECT_EQ(content(folder / "a.ply"), "one");
  ASSERT_TRUE(write_file(folder / "b.ply", {}, true).has_value());
  EXPECT_EQ(content(folder / "b.ply"), "");
  ASSERT_TRUE(write_file(folder / std::string(250, 'n'), bytes_of("long"), false).has_value());
  EXPECT_EQ(folder.entry_count(), 3u);
  const std::vector<std::uint8_t> big(3u << 20, 0xA5);
  ASSERT_TRUE(write_file(folder / "big", big, false).has_value());
  EXPECT_EQ(*read_file(folder / "big"), big);
}

TEST(WriteFile, OverwritesOnlyWhenTold) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "a", bytes_of("one"), true).has_value());
  expect_cannot_write(write_file(folder / "a", bytes_of("two"), false), "exists already");
  EXPECT_EQ(content(folder / "a"), "one");
  fs::permissions(folder / "a", fs::perms::owner_read | fs::perms::owner_write);
  ASSERT_TRUE(write_file(folder / "a", bytes_of("three"), true).has_value());
  EXPECT_EQ(content(folder / "a"), "three");
  EXPECT_EQ(fs::status(folder / "a").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(WriteFile, OneOfSeveralWritersWins) {
  const TemporaryFolder folder;
  std::array<bool, 8> won{};
  std::vector<std::thread> writers;
  for (std::size_t i = 0; i < won.size(); ++i) {
    writers.emplace_back([&, i] {
      won[i] = write_file(folder / "a", bytes_of(std::to_string(i)), false).has_value();
    });
  }
  for (std::thread& writer : writers) writer.join();
  ASSERT_EQ(std::count(won.begin(), won.end(), true), 1);
  const auto winner = std::find(won.begin(), won.end(), true) - won.begin();
  EXPECT_EQ(content(folder / "a"), std::to_string(winner));
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(WriteFile, LinksStayAndWhatTheyNameIsReplaced) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "a", bytes_of("one"), false).has_value());
  fs::create_symlink("a", folder / "link");
  expect_cannot_write(write_file(folder / "link", bytes_of("two"), false), "exists already");
  ASSERT_TRUE(write_file(folder / "link", bytes_of("two"), true).has_value());
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(content(folder / "a"), "two");
  fs::create_symlink("nowhere", folder / "dangling");
  expect_cannot_write(write_file(folder / "dangling", bytes_of("x"), true), "a link to nothing");
}

TEST(WriteFile, DevicesAndPipesAreWrittenThrough) {
  ASSERT_TRUE(write_file("/dev/null", bytes_of("x"), false).has_value());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = content(folder / "pipe"); });
  const std::string sent(300000, 'p');
  EXPECT_TRUE(write_file(folder / "pipe", bytes_of(sent), false).has_value());
  reader.join();
  EXPECT_EQ(got, sent);
}

TEST(WriteFile, FailuresLeaveNothing) {
  const TemporaryFolder folder;
  expect_cannot_write(write_file(folder / "no/a.ply", bytes_of("x"), true),
                      "No such file or directory");
  expect_cannot_write(write_file(folder.path(), bytes_of("x"), true), "is a folder");
  expect_cannot_write(write_file(folder.path().string() + "/", bytes_of("x"), true),
                      "is not a file name");
  expect_cannot_write(write_file("", bytes_of("x"), true), "is not a file name");
  expect_cannot_write(write_file(folder / std::string(300, 'n'), bytes_of("x"), true),
                      "File name too long");
  expect_cannot_write(write_file("/dev/full", bytes_of("x"), true), "No space left");
  EXPECT_EQ(folder.entry_count(), 0u);

  // A disk that fills up half way.
  ASSERT_TRUE(write_file(folder / "a", bytes_of("old"), false).has_value());
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const Result<void> full = write_file(folder / "a", std::vector<std::uint8_t>(100000, 1), true);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  expect_cannot_write(full, "nothing was kept");
  EXPECT_EQ(content(folder / "a"), "old");
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(ReadFile, SaysWhyNot) {
  const TemporaryFolder folder;
  for (const auto& [file, part] :
       {std::pair{folder / "none", "no such file"}, {folder.path(), "is a folder"}}) {
    const auto bytes = read_file(file);
    ASSERT_FALSE(bytes.has_value());
    EXPECT_EQ(bytes.error().code, ErrorCode::kUnreadableFile);
    EXPECT_NE(bytes.error().message.find(part), std::string::npos);
  }
  EXPECT_GT((*read_file("/proc/self/status")).size(), 100u);  // claims to be empty, but is not
}

}  // namespace
}  // namespace nacre::io
