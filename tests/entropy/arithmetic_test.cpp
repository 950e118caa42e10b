// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/arithmetic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace nacre::entropy {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A message over one model and, now and then, raw bits: symbol < 0 means ~symbol raw 5-bit values.
struct Message {
  AdaptiveModel model{1};
  std::vector<int> symbols;
};

int below(std::mt19937_64& random, int n) {
  return static_cast<int>(random() % static_cast<std::uint64_t>(n));
}

/// Alphabet 1 .. 64, from uniform to nearly certain, favouring the first, the last or any symbol.
Message random_message(std::mt19937_64& random, int max_length) {
  const int alphabet = 1 + below(random, below(random, 2) == 0 ? 4 : 64);
  const int favoured = below(random, alphabet);
  const int rareness = 1 + below(random, 1 << below(random, 13));
  Message message;
  message.model = AdaptiveModel(alphabet, 1u + static_cast<std::uint32_t>(below(random, 4096)));
  message.symbols.resize(static_cast<std::size_t>(below(random, max_length + 1)));
  for (int& symbol : message.symbols) {
    symbol = below(random, rareness) == 0 ? below(random, alphabet) : favoured;
    if (below(random, 50) == 0) symbol = ~below(random, 32);
  }
  return message;
}

Bytes encode(const Message& message) {
  ArithmeticEncoder encoder;
  AdaptiveModel model = message.model;
  for (const int symbol : message.symbols) {
    if (symbol < 0) {
      encoder.encode_bits(static_cast<std::uint32_t>(~symbol), 5);
    } else {
      encoder.encode(symbol, model);
    }
  }
  return encoder.finish();
}

/// Decodes as many symbols as `message` has, of the same kinds; true if the payload ended exactly.
bool decode_like(const Message& message, const Bytes& bytes, std::vector<int>& decoded) {
  ArithmeticDecoder decoder(bytes);
  AdaptiveModel model = message.model;
  decoded.clear();
  for (const int symbol : message.symbols) {
    decoded.push_back(symbol < 0 ? ~static_cast<int>(decoder.decode_bits(5))
                                 : decoder.decode(model));
  }
  return decoder.ends_exactly();
}

TEST(Arithmetic, RoundTripsRandomModelsAndLengths) {
  std::mt19937_64 random(11);
  std::vector<int> decoded;
  for (int i = 0; i < 3000; ++i) {
    const Message message = random_message(random, 400);
    ASSERT_TRUE(decode_like(message, encode(message), decoded)) << "message " << i;
    ASSERT_EQ(decoded, message.symbols) << "message " << i;
  }
}

TEST(Arithmetic, RejectsEveryTruncationAndExtension) {
  std::mt19937_64 random(12);
  std::vector<int> decoded;
  for (int i = 0; i < 1500; ++i) {
    const Message message = random_message(random, 100);
    const Bytes full = encode(message);
    for (std::size_t size = 0; size < full.size(); ++size) {
      const Bytes cut(full.data(), full.data() + size);
      ASSERT_FALSE(decode_like(message, cut, decoded)) << size << " of " << full.size();
    }
    for (const int extra : {0x00, 0x01, 0x80, 0xFF}) {
      Bytes longer = full;
      longer.push_back(static_cast<std::uint8_t>(extra));
      ASSERT_FALSE(decode_like(message, longer, decoded)) << "extra byte " << extra;
      // Nothing that follows the code changes what it says.
      ASSERT_EQ(decoded, message.symbols);
    }
  }
}

TEST(Arithmetic, AcceptsOnlyWhatTheEncoderWrites) {
  std::mt19937_64 random(13);
  std::vector<int> decoded;
  int accepted = 0;
  for (int i = 0; i < 30000; ++i) {
    Message message = random_message(random, 12);
    Bytes bytes(static_cast<std::size_t>(below(random, 5)));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (!decode_like(message, bytes, decoded)) continue;
    ++accepted;
    message.symbols = decoded;
    ASSERT_EQ(encode(message), bytes);
  }
  EXPECT_GT(accepted, 100);
}

TEST(Arithmetic, NothingAndCertainSymbolsTakeNoBytes) {
  EXPECT_TRUE(ArithmeticEncoder().finish().empty());
  Message certain;
  certain.symbols.assign(1000, 0);
  EXPECT_TRUE(encode(certain).empty());
  std::vector<int> decoded;
  EXPECT_TRUE(decode_like(certain, {}, decoded));
  EXPECT_EQ(decoded, certain.symbols);
}

TEST(Arithmetic, FinishLeavesAnEmptyEncoder) {
  ArithmeticEncoder encoder;
  encoder.encode_bits(0xABC, 12);
  const Bytes first = encoder.finish();
  encoder.encode_bits(0xABC, 12);
  EXPECT_EQ(encoder.finish(), first);
  EXPECT_TRUE(encoder.finish().empty());
}

TEST(Arithmetic, CostIsTheIdealAdaptiveCost) {
  std::mt19937_64 random(14);
  for (int i = 0; i < 400; ++i) {
    const Message message = random_message(random, 20000);
    AdaptiveModel model = message.model;
    double ideal_bits = 0;
    for (const int symbol : message.symbols) {
      if (symbol < 0) {
        ideal_bits += 5;
      } else {
        ideal_bits -= std::log2(double(model.frequency(symbol)) / double(model.total()));
        model.update(symbol);
      }
    }
    const double bytes = static_cast<double>(encode(message).size());
    EXPECT_LE(bytes, 1.002 * ideal_bits / 8 + 2);
    // What range / total leaves over goes to the last symbol: up to 6 bits gained each time it
    // comes up with a frequency of 1, at hardly any cost to the others.
    EXPECT_GE(bytes, 0.95 * ideal_bits / 8);
  }
}

TEST(Arithmetic, CarryRunsThroughManyFullBytes) {
  // Thirds, coded afresh each time. The symbols of the code value 0x7FFF.. keep the interval around
  // 0x8000..; those after them decide whether a carry runs through all the 0xFF held back.
  Bytes half(100, 0xFF);
  half[0] = 0x7F;
  ArithmeticDecoder half_decoder(half);
  std::vector<int> symbols;
  std::size_t carried = 0;
  for (int length = 1; length <= 400; ++length) {
    AdaptiveModel third(3);
    symbols.push_back(half_decoder.decode(third));
    for (const int last : {0, 1, 2}) {
      std::vector<int> tail = symbols;
      tail.insert(tail.end(), {last, last, last, 0, 2});
      ArithmeticEncoder encoder;
      for (const int symbol : tail) encoder.encode(symbol, third = AdaptiveModel(3));
      const Bytes bytes = encoder.finish();
      ArithmeticDecoder decoder(bytes);
      for (const int symbol : tail) ASSERT_EQ(decoder.decode(third = AdaptiveModel(3)), symbol);
      ASSERT_TRUE(decoder.ends_exactly());
      const std::array<std::uint8_t, 5> carry = {0x80, 0x00, 0x00, 0x00, 0x00};
      if (bytes.size() > 5 && std::equal(carry.begin(), carry.end(), bytes.begin())) ++carried;
    }
  }
  EXPECT_GT(carried, 100u);
}

TEST(Arithmetic, EndsOnAnyBytes) {
  std::mt19937_64 random(15);
  for (int i = 0; i < 300; ++i) {
    Bytes bytes(static_cast<std::size_t>(below(random, 200)));
    const bool ones = below(random, 10) == 0;
    for (std::uint8_t& byte : bytes) byte = ones ? 0xFF : static_cast<std::uint8_t>(random());
    ArithmeticDecoder decoder(bytes);
    AdaptiveModel model(1 + below(random, 64));
    std::size_t symbols = 0;
    for (; symbols < 1000 && !decoder.overrun(); ++symbols) {
      ASSERT_LT(decoder.decode(model), model.symbol_count());
      ASSERT_LT(decoder.decode_bits(13), 1u << 13);
    }
    EXPECT_TRUE(decoder.overrun());  // 13 bits a turn use up 200 bytes long before
    EXPECT_FALSE(decoder.ends_exactly());
  }
}

TEST(AdaptiveModel, HalvesAndKeepsEverySymbolPossible) {
  AdaptiveModel model(256, AdaptiveModel::kMaxIncrement);
  for (int i = 0; i < 5000; ++i) {
    model.update(i < 4000 ? 7 : i % 256);
    ASSERT_LE(model.total(), AdaptiveModel::kMaxTotal);
  }
  std::uint32_t sum = 0;
  for (int s = 0; s < 256; ++s) {
    ASSERT_GE(model.frequency(s), 1u);
    ASSERT_EQ(model.cumulative(s), sum);
    ASSERT_EQ(model.find(sum), s);
    ASSERT_EQ(model.find(sum + model.frequency(s) - 1), s);
    sum += model.frequency(s);
  }
  EXPECT_EQ(sum, model.total());
}

TEST(AdaptiveModel, StartsFromGivenFrequencies) {
  const AdaptiveModel model(std::vector<std::uint16_t>{3, 1, 60000}, 24);
  EXPECT_LE(model.total(), AdaptiveModel::kMaxTotal);
  EXPECT_EQ(model.frequency(0), 2u);
  EXPECT_EQ(model.frequency(1), 1u);
  EXPECT_EQ(model.frequency(2), 30000u);
}

}  // namespace
}  // namespace nacre::entropy
