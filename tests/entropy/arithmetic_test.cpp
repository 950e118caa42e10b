// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/arithmetic.h"

#include <gtest/gtest.h>

#include <algorithm>
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
    for (const std::uint8_t extra : {0x00, 0x01, 0x80, 0xFF}) {
      Bytes longer = full;
      longer.push_back(extra);
      ASSERT_FALSE(decode_like(message, longer, decoded)) << "extra byte " << int{extra};
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
    EXPECT_GE(bytes, 0.998 * ideal_bits / 8);
  }
}

TEST(Arithmetic, CarryRunsThroughManyFullBytes) {
  // Raw bits 0x7FFF.. hold bytes of 0xFF back; what follows decides whether a carry runs through.
  for (int length = 0; length < 40; ++length) {
    for (const std::uint32_t last : {0u, 1u, 0x7Fu, 0xFEu, 0xFFu}) {
      Message message;
      message.model = AdaptiveModel(std::vector<std::uint16_t>{1, 32766, 1}, 1);
      message.symbols = {1};
      message.symbols.insert(message.symbols.end(), static_cast<std::size_t>(length), ~31);
      message.symbols.push_back(~static_cast<int>(last >> 3));
      message.symbols.push_back(2);
      message.symbols.push_back(0);
      std::vector<int> decoded;
      ASSERT_TRUE(decode_like(message, encode(message), decoded));
      ASSERT_EQ(decoded, message.symbols);
    }
  }
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
