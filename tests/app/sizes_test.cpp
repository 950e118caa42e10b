// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/sizes.h"

#include <gtest/gtest.h>

#include <utility>

namespace nacre::app {
namespace {

TEST(ParseSize, ReadsWhatPeopleWrite) {
  const std::pair<const char*, std::uint64_t> cases[] = {{"6061", 6061},
                                                         {"6k", 6000},
                                                         {"6K", 6000},
                                                         {"6kB", 6000},
                                                         {"6Ki", 6144},
                                                         {"6KiB", 6144},
                                                         {"1.5M", 1'500'000},
                                                         {"1.5Mi", 1'572'864},
                                                         {"2G", 2'000'000'000},
                                                         {"1Gi", 1'073'741'824},
                                                         {".5k", 500},
                                                         {"1.k", 1000},
                                                         {"12B", 12},
                                                         {"0.0015k", 1},
                                                         {"4.35k", 4350},
                                                         {"1.1k", 1100},
                                                         {"0.999999999G", 999'999'999}};
  for (const auto& [text, bytes] : cases) {
    const Result<std::uint64_t> parsed = parse_size(text);
    ASSERT_TRUE(parsed.has_value()) << text;
    EXPECT_EQ(*parsed, bytes) << text;
  }
}

TEST(ParseSize, RefusesEverythingElse) {
  for (const char* text : {"",
                           " ",
                           "k",
                           ".",
                           ".k",
                           "-5",
                           "+5",
                           "1e3",
                           "6 k",
                           " 6",
                           "6q",
                           "6kk",
                           "6ib",
                           "6i",
                           "0",
                           "0.0k",
                           "0.4",
                           "nan",
                           "inf",
                           "0x10",
                           "1,5M",
                           "1.0000000001G",
                           "99999999999999999999",
                           "9223372036854775808",
                           "5000000000Gi",
                           "18446744073709551617"}) {
    const Result<std::uint64_t> parsed = parse_size(text);
    ASSERT_FALSE(parsed.has_value()) << text << " gave " << *parsed;
    EXPECT_EQ(parsed.error().code, ErrorCode::kBadInput);
  }
}

TEST(FormatBytes, KeepsThreeDigits) {
  EXPECT_EQ(format_bytes(0), "0 B");
  EXPECT_EQ(format_bytes(999), "999 B");
  EXPECT_EQ(format_bytes(1000), "1.00 kB");
  EXPECT_EQ(format_bytes(6061), "6.06 kB");
  EXPECT_EQ(format_bytes(118'400), "118 kB");
  EXPECT_EQ(format_bytes(999'499), "999 kB");
  EXPECT_EQ(format_bytes(999'500), "1.00 MB");
  EXPECT_EQ(format_bytes(22'949'999), "22.9 MB");
  EXPECT_EQ(format_bytes(1'100'000'000), "1.10 GB");
}

TEST(FormatCount, GroupsByThree) {
  EXPECT_EQ(format_count(0), "0");
  EXPECT_EQ(format_count(999), "999");
  EXPECT_EQ(format_count(1000), "1,000");
  EXPECT_EQ(format_count(1'204'331), "1,204,331");
}

}  // namespace
}  // namespace nacre::app
