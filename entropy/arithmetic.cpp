// SPDX-License-Identifier: Apache-2.0
//
// Read me first: a code is a number in [0, 1) written in base 256. Coding a symbol narrows the
// interval [low, low + range) that holds it. The last symbol of an alphabet also gets what the
// division range / total leaves over, so a certain symbol costs nothing and every code value
// belongs to some symbol.
#include "entropy/arithmetic.h"

#include <algorithm>
#include <cassert>

namespace nacre::entropy {
namespace {

constexpr std::uint32_t kFullRange = 0xFFFFFFFFu;
constexpr std::uint32_t kMinRange = 1u << 24;

struct CodeEnd {
  std::uint64_t value;  // >= low, the last bytes of the code; zero below `byte_count` bytes
  int byte_count;       // of the 4 bytes of `value`, most significant first
};

// The shortest byte string such that all its continuations stay inside [low, low + range). One byte
// is 2^24 wide and may not fit (range can be as small as 2^24); two always do.
CodeEnd code_end(std::uint64_t low, std::uint32_t range) {
  for (int byte_count = 1;; ++byte_count) {
    const std::uint64_t width = std::uint64_t{1} << (32 - 8 * byte_count);
    const std::uint64_t value = (low + width - 1) & ~(width - 1);
    if (value + width <= low + range) return {value, byte_count};
  }
}

/// A 1's part of the range; neither part is empty, as range >= 2^24.
std::uint32_t share(std::uint32_t range, std::uint32_t probability) {
  return static_cast<std::uint32_t>((std::uint64_t{range} * probability) >> 16);
}

}  // namespace

AdaptiveModel::AdaptiveModel(int symbol_count, std::uint32_t increment)
    : frequencies_(static_cast<std::size_t>(symbol_count), 1u),
      total_(static_cast<std::uint32_t>(symbol_count)),
      increment_(increment) {
  assert(symbol_count >= 1 && symbol_count <= 256);
  assert(increment >= 1 && increment <= kMaxIncrement);
}

AdaptiveModel::AdaptiveModel(std::span<const std::uint16_t> frequencies, std::uint32_t increment)
    : frequencies_(frequencies.begin(), frequencies.end()), increment_(increment) {
  assert(!frequencies.empty() && frequencies.size() <= 256);
  assert(increment >= 1 && increment <= kMaxIncrement);
  for (const std::uint32_t f : frequencies_) {
    assert(f >= 1);
    total_ += f;
  }
  halve_while_too_large();
}

void AdaptiveModel::update(int symbol) {
  frequencies_[static_cast<std::size_t>(symbol)] += increment_;
  total_ += increment_;
  if (total_ > kMaxTotal) halve_while_too_large();
}

void AdaptiveModel::halve_while_too_large() {
  while (total_ > kMaxTotal) {
    total_ = 0;
    for (std::uint32_t& f : frequencies_) {
      f = (f + 1) / 2;
      total_ += f;
    }
  }
}

std::uint32_t AdaptiveModel::cumulative(int symbol) const {
  std::uint32_t sum = 0;
  for (int s = 0; s < symbol; ++s) sum += frequency(s);
  return sum;
}

int AdaptiveModel::find(std::uint32_t cumulative_value) const {
  int symbol = 0;
  for (const int last = symbol_count() - 1; symbol < last; ++symbol) {
    if (cumulative_value < frequency(symbol)) break;
    cumulative_value -= frequency(symbol);
  }
  return symbol;
}

void ArithmeticEncoder::encode(int symbol, AdaptiveModel& model) {
  assert(symbol >= 0 && symbol < model.symbol_count());
  encode_interval(model.cumulative(symbol), model.frequency(symbol), model.total());
  model.update(symbol);
}

void ArithmeticEncoder::encode_bits(std::uint32_t bits, int count) {
  assert(count >= 0 && count <= 16 && bits < (1u << count));
  encode_interval(bits, 1, 1u << count);
}

void ArithmeticEncoder::encode_bit(bool bit, std::uint32_t probability) {
  assert(probability >= 1 && probability <= 65535);
  const std::uint32_t split = share(range_, probability);
  if (bit) {
    range_ = split;
  } else {
    low_ += split;
    range_ -= split;
  }
  while (range_ < kMinRange) {
    range_ <<= 8;
    shift_low();
  }
}

void ArithmeticEncoder::encode_interval(std::uint32_t low, std::uint32_t size,
                                        std::uint32_t total) {
  const std::uint32_t unit = range_ / total;
  low_ += std::uint64_t{unit} * low;
  range_ = low + size == total ? range_ - unit * low : unit * size;
  while (range_ < kMinRange) {
    range_ <<= 8;
    shift_low();
  }
}

// A byte is written once no later carry can reach it: it is held in cache_, and a row of 0xFF
// behind it (through which a carry would run) is only counted.
void ArithmeticEncoder::shift_low() {
  const bool carry = (low_ >> 32) != 0;
  if (carry || low_ < 0xFF000000u) {
    if (started_) bytes_.push_back(static_cast<std::uint8_t>(cache_ + (carry ? 1 : 0)));
    bytes_.insert(bytes_.end(), pending_, carry ? std::uint8_t{0x00} : std::uint8_t{0xFF});
    pending_ = 0;
    cache_ = static_cast<std::uint8_t>(low_ >> 24);
    started_ = true;
  } else {
    ++pending_;
  }
  low_ = (low_ & 0x00FFFFFFu) << 8;
}

std::vector<std::uint8_t> ArithmeticEncoder::finish() {
  if (range_ != kFullRange || started_ || pending_ > 0) {
    const CodeEnd end = code_end(low_, range_);
    low_ = end.value;
    for (int i = 0; i < end.byte_count; ++i) shift_low();
    if (started_) bytes_.push_back(cache_);
    bytes_.insert(bytes_.end(), pending_, std::uint8_t{0xFF});
  }
  std::vector<std::uint8_t> bytes = std::move(bytes_);
  *this = ArithmeticEncoder();
  return bytes;
}

ArithmeticDecoder::ArithmeticDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  for (std::size_t i = 0; i < kLookAhead; ++i) read_byte();
  code_ = window_;
  if (code_ == kFullRange) {  // outside the first interval
    overrun_ = true;
    code_ = 0;
  }
}

int ArithmeticDecoder::decode(AdaptiveModel& model) {
  const int symbol = model.find(target(model.total()));
  consume(model.cumulative(symbol), model.frequency(symbol), model.total());
  model.update(symbol);
  return symbol;
}

bool ArithmeticDecoder::ends_exactly() const {
  if (overrun_) return false;
  const std::size_t shifts = position_ - kLookAhead;
  if (range_ == kFullRange && shifts == 0) return bytes_.empty();
  const std::uint32_t low = window_ - code_;  // the encoder's low_ mod 2^32
  const CodeEnd end = code_end(low, range_);
  return bytes_.size() == shifts + static_cast<std::size_t>(end.byte_count) &&
         end.value - low == code_;
}

}  // namespace nacre::entropy
