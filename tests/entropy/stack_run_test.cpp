// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/stack_run.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace nacre::entropy {
namespace {

using Values = std::vector<std::int64_t>;
using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t kLargest = (std::int64_t{1} << 62) - 1;

/// Uniform in [0, 1), the same on every machine.
double unit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

Values laplacian(std::size_t count, double scale, std::mt19937_64& random) {
  Values values(count);
  for (std::int64_t& value : values) {
    const double centred = unit(random) - 0.5;
    value = std::llround(-scale * std::copysign(std::log1p(-2 * std::abs(centred)), centred));
  }
  return values;
}

/// Zero runs and values of every length up to 62 bits, of both signs.
Values random_values(std::mt19937_64& random, std::size_t max_count) {
  Values values(random() % (max_count + 1));
  const std::uint64_t sparseness = 1 + random() % 20;
  const std::uint64_t max_bits = 1 + random() % 62;
  for (std::int64_t& value : values) {
    if (random() % sparseness != 0) continue;
    value = static_cast<std::int64_t>(random() >> (64 - 1 - random() % max_bits));
    if (random() % 2 == 0) value = -value;
  }
  return values;
}

double entropy_bits_per_value(const Values& values) {
  std::map<std::int64_t, double> histogram;
  for (const std::int64_t value : values) ++histogram[value];
  double bits = 0;
  for (const auto& [value, n] : histogram) bits -= n * std::log2(n / double(values.size()));
  return bits / static_cast<double>(values.size());
}

/// The rules read the other way, as slowly and plainly as possible: symbols to values.
Values parse(const std::string& symbols, std::size_t count) {
  Values values;
  std::size_t at = 0;
  while (at < symbols.size()) {
    std::string run;
    while (at < symbols.size() && (symbols[at] == '+' || symbols[at] == '-')) run += symbols[at++];
    if (run.find('-') != std::string::npos) run += '+';  // the dropped top bit
    std::uint64_t length = 0;
    for (std::size_t i = 0; i < run.size(); ++i) length |= std::uint64_t{run[i] == '+'} << i;
    values.insert(values.end(), length, 0);
    if (at == symbols.size()) break;
    std::int64_t code = 0;
    int bit = 0;
    for (; symbols[at] == '0' || symbols[at] == '1'; ++at) {
      code |= std::int64_t{symbols[at] == '1'} << bit++;
    }
    code |= std::int64_t{1} << bit;
    values.push_back(symbols[at++] == '-' ? 1 - code : code - 1);
  }
  values.resize(count, 0);
  return values;
}

TEST(StackRunSymbols, StacksOfThePublishedRules) {
  const std::map<std::int64_t, std::string> golden = {{1, "0+"},  {-1, "0-"},  {2, "1+"},
                                                      {3, "00+"}, {-4, "10-"}, {7, "000+"}};
  for (const auto& [value, symbols] : golden) EXPECT_EQ(stack_run_symbols(Values{value}), symbols);
}

TEST(StackRunSymbols, RunsOfThePublishedRules) {
  const std::array<std::string, 9> golden = {"", "+", "-", "++", "--", "+-", "-+", "+++", "---"};
  for (std::size_t length = 0; length < golden.size(); ++length) {
    Values values(length, 0);
    values.push_back(1);
    EXPECT_EQ(stack_run_symbols(values), golden[length] + "0+");
  }
}

TEST(StackRunSymbols, TheLastRunIsSentUnlessAllIsZero) {
  EXPECT_EQ(stack_run_symbols(Values{}), "");
  EXPECT_EQ(stack_run_symbols(Values{0, 0, 0}), "");
  EXPECT_EQ(stack_run_symbols(Values{0, 0, -2, 5}), "-1-01+");
  EXPECT_EQ(stack_run_symbols(Values{0, 0, -2, 5, 0, 0, 0, 0}), "-1-01+--");
}

TEST(StackRunSymbols, ReadBackByThePlainParser) {
  std::mt19937_64 random(21);
  for (int i = 0; i < 3000; ++i) {
    const Values values = random_values(random, 200);
    ASSERT_EQ(parse(stack_run_symbols(values), values.size()), values);
  }
}

TEST(StackRun, TheWorkedExampleOfTheReadme) {
  const Values values = {0, 0, -2, 5, 0, 0, 0, 0};
  const Bytes bytes = {0xE5, 0x37, 0xEA};
  EXPECT_EQ(stack_run_symbols(values), "-1-01+--");
  EXPECT_EQ(encode_stack_run(values), bytes);
  EXPECT_EQ(*decode_stack_run(bytes, values.size()), values);
}

TEST(StackRun, RoundTripsRandomSequences) {
  std::mt19937_64 random(22);
  for (int i = 0; i < 5000; ++i) {
    const Values values = random_values(random, 300);
    const auto decoded = decode_stack_run(encode_stack_run(values), values.size());
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    ASSERT_EQ(*decoded, values);
  }
}

TEST(StackRun, RoundTripsEveryRunLengthAndBitLength) {
  for (std::size_t run = 0; run < 300; ++run) {
    for (const bool ends_in_zeros : {false, true}) {
      Values values(run, 0);
      values.insert(ends_in_zeros ? values.begin() : values.end(), 3);
      const auto decoded = decode_stack_run(encode_stack_run(values), values.size());
      ASSERT_TRUE(decoded.has_value());
      ASSERT_EQ(*decoded, values);
    }
  }
  Values values = {kLargest, -kLargest};
  for (std::int64_t power = 1; power <= kLargest / 2; power *= 2) {
    values.insert(values.end(), {power, -power, power - 1, 1 - power, power + 1});
  }
  const auto decoded = decode_stack_run(encode_stack_run(values), values.size());
  ASSERT_TRUE(decoded.has_value());
  EXPECT_EQ(*decoded, values);
}

TEST(StackRun, NoValuesOrOnlyZerosTakeNoBytes) {
  for (const std::size_t count : {0u, 1u, 2u, 1000u, 1000000u}) {
    const Values zeros(count, 0);
    EXPECT_TRUE(encode_stack_run(zeros).empty());
    const auto decoded = decode_stack_run({}, count);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_EQ(*decoded, zeros);
  }
}

TEST(StackRunDecode, RejectsEveryTruncationAndExtension) {
  std::mt19937_64 random(23);
  for (int i = 0; i < 300; ++i) {
    const Values values = random_values(random, 150);
    const Bytes full = encode_stack_run(values);
    // The empty payload is a payload: that of all zeros.
    for (std::size_t size = 1; size < full.size(); ++size) {
      const Bytes cut(full.data(), full.data() + size);
      const auto decoded = decode_stack_run(cut, values.size());
      ASSERT_FALSE(decoded.has_value()) << "accepted " << size << " of " << full.size();
      ASSERT_EQ(decoded.error().code, ErrorCode::kCorruptStream);
    }
    for (const int extra : {0x00, 0x01, 0x7F, 0xFF}) {
      Bytes longer = full;
      longer.push_back(static_cast<std::uint8_t>(extra));
      ASSERT_FALSE(decode_stack_run(longer, values.size()).has_value());
    }
  }
}

TEST(StackRunDecode, ReadsExactlyItsPayloadBetweenFences) {
  std::mt19937_64 random(24);
  for (int i = 0; i < 200; ++i) {
    const Values values = random_values(random, 100);
    const Bytes payload = encode_stack_run(values);
    for (const int fence : {0x00, 0xA5, 0xFF}) {
      Bytes fenced(8, static_cast<std::uint8_t>(fence));
      fenced.insert(fenced.begin() + 4, payload.begin(), payload.end());
      const auto decoded =
          decode_stack_run(std::span(fenced).subspan(4, payload.size()), values.size());
      ASSERT_TRUE(decoded.has_value());
      ASSERT_EQ(*decoded, values);
    }
  }
}

TEST(StackRunDecode, RejectsAnotherCount) {
  const Values values = {0, 3, 0, 0, -1, 0, 0, 0, 9, 0, 0};
  const Bytes bytes = encode_stack_run(values);
  for (std::size_t count = 0; count < 40; ++count) {
    if (count == values.size()) continue;
    const auto decoded = decode_stack_run(bytes, count);
    // Another count may make other sense of the same bytes, but never the same values.
    if (decoded) {
      EXPECT_EQ(encode_stack_run(*decoded), bytes) << count;
    }
  }
  EXPECT_FALSE(decode_stack_run(bytes, 0).has_value());
  EXPECT_FALSE(decode_stack_run(bytes, 8).has_value());
}

TEST(StackRunDecode, AcceptsOnlyWhatTheEncoderWrites) {
  std::mt19937_64 random(25);
  int accepted = 0;
  for (int i = 0; i < 50000; ++i) {
    Bytes bytes(random() % 6);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const std::size_t count = random() % 12;
    const auto decoded = decode_stack_run(bytes, count);
    if (!decoded) {
      ASSERT_EQ(decoded.error().code, ErrorCode::kCorruptStream);
      continue;
    }
    ++accepted;
    ASSERT_EQ(decoded->size(), count);
    ASSERT_EQ(encode_stack_run(*decoded), bytes);
  }
  EXPECT_GT(accepted, 1000);
}

TEST(StackRunDecode, EndsOnLongRandomBytesAndHugeCounts) {
  std::mt19937_64 random(26);
  for (int i = 0; i < 300; ++i) {
    Bytes bytes(1 + random() % 3000);
    const std::uint64_t kind = random() % 3;
    for (std::uint8_t& byte : bytes) {
      byte = kind == 0 ? 0x00 : kind == 1 ? 0xFF : static_cast<std::uint8_t>(random());
    }
    EXPECT_FALSE(decode_stack_run(bytes, 1u << 20).has_value());
  }
}

// The cost over the order-0 entropy of 60,000 independent Laplacian values; the percentages are
// those of an ideal adaptive coder with the same two contexts.
TEST(StackRunCost, IsThatOfAnIdealCoderOnLaplacianValues) {
  struct Row {
    double entropy;
    double excess_percent;
  };
  constexpr std::array<Row, 9> kRows = {{{0.27, 13.2},
                                         {0.49, 11.1},
                                         {0.93, 9.0},
                                         {1.56, 6.0},
                                         {2.18, 3.6},
                                         {3.05, 2.7},
                                         {4.03, 3.3},
                                         {5.43, 6.1},
                                         {6.76, 8.8}}};
  for (const Row& row : kRows) {
    double low = 0.05;
    double high = 200;
    Values values;
    double entropy = 0;
    for (int i = 0; i < 30; ++i) {
      std::mt19937_64 random(27);
      const double scale = std::sqrt(low * high);
      values = laplacian(60000, scale, random);
      entropy = entropy_bits_per_value(values);
      (entropy < row.entropy ? low : high) = scale;
    }
    const double bits = 8.0 * static_cast<double>(encode_stack_run(values).size()) / 60000;
    const double excess_percent = 100 * (bits / entropy - 1);
    std::printf("%5.2f bit/value: stack-run +%.1f %% (ideal +%.1f %%)\n", entropy, excess_percent,
                row.excess_percent);
    EXPECT_NEAR(entropy, row.entropy, 0.005);
    EXPECT_NEAR(excess_percent, row.excess_percent, 1.0);
  }
}

}  // namespace
}  // namespace nacre::entropy
