// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/detail_symbols.h"

#include <gtest/gtest.h>

#include "support/shapes.h"

namespace nacre::entropy {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Three bands over an open mesh; the second and third have blocks of zeros.
class DetailSymbols : public testing::Test {
 protected:
  DetailSymbols() {
    std::uint32_t state = 7;
    for (int j = 0; j < 3; ++j) {
      BandSymbols band;
      band.points.assign(topology_.band_size(j), {0, 0, 0});
      const std::size_t end = j == 0 ? band.points.size() : band.points.size() / 3;
      for (std::size_t e = 0; e < end; ++e) {
        state = state * 1664525u + 1013904223u;
        const auto value = static_cast<std::int32_t>((state >> 24) % 7) - 3;
        band.points[e] = {value, j == 1 ? value / 2 : 0, 0};
      }
      band.has_tangential = j == 1;
      band.ratio_quarters = j == 1 ? 5 : 0;
      band.shrink_32nds = {-8, j, 7};
      bands_.push_back(std::move(band));
    }
  }
  [[nodiscard]] BandPlace place(int j) const {
    return {&topology_.level(j), j > 0 ? &topology_.level(j - 1) : nullptr, j, 0};
  }
  [[nodiscard]] Bytes written(const BandSymbols& band) const {
    DetailModel model;
    return write_band_symbols(band, place(0), model).value();
  }

  Scan scan_ = shapes::grid(4, 4);
  Topology topology_ =
      *Topology::build(scan_.triangles, static_cast<std::uint32_t>(scan_.positions.size()), 3);
  std::vector<BandSymbols> bands_;
};

TEST_F(DetailSymbols, RoundTripAndAreWhatTheDecoderReads) {
  DetailModel writer, reader, rewriter, decoder;
  for (int j = 0; j < 3; ++j) {
    const BandSymbols& band = bands_[static_cast<std::size_t>(j)];
    const auto payload = write_band_symbols(band, place(j), writer);
    ASSERT_TRUE(payload.has_value()) << payload.error().message;
    const auto read = read_band_symbols(*payload, place(j), reader);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ(read->points, band.points);
    EXPECT_EQ(read->shrink_32nds, band.shrink_32nds);
    EXPECT_EQ(read->ratio_quarters, band.ratio_quarters);
    EXPECT_EQ(read->has_tangential, band.has_tangential);
    EXPECT_EQ(read->heads.size(), (band.points.size() + kBlockDetails - 1) / kBlockDetails);
    EXPECT_EQ(write_band_symbols(*read, place(j), rewriter).value(), *payload);
    const auto decoded = decode_details(*payload, place(j), decoder);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    EXPECT_EQ(decoded->shrink_32nds, band.shrink_32nds);
    for (const DetailBand::Nonzero& n : decoded->points) EXPECT_EQ(n.point, band.points[n.edge]);
  }
}

TEST_F(DetailSymbols, HeadsThatSayMoreThanIsNeededAreKept) {
  BandSymbols band = bands_[0];
  band.heads.assign((band.points.size() + kBlockDetails - 1) / kBlockDetails, 1);
  const Bytes payload = written(band);
  DetailModel model;
  EXPECT_EQ(read_band_symbols(payload, place(0), model)->points, band.points);
}

TEST_F(DetailSymbols, ABandOfZerosHasNoPayload) {
  BandSymbols band = bands_[0];
  band.points.assign(band.points.size(), {0, 0, 0});
  EXPECT_TRUE(written(band).empty());
  EXPECT_TRUE(written({}).empty());
  // Zeros written out are nothing that a decoder takes.
  DetailModel model;
  DetailEncoder encoder(model, place(0), false, 0);
  for (std::uint32_t e = 0; e < band.points.size(); ++e) {
    if (e % kBlockDetails == 0) encoder.begin_block(e / kBlockDetails, true, false);
    const DetailContext context = encoder.look(e);
    if (encoder.is_open(context)) encoder.put(context, {0, 0, 0});
  }
  const Bytes zeros = encoder.finish({0, 0, 0});
  DetailModel reader, decoder;
  EXPECT_EQ(decode_details(zeros, place(0), decoder).error().code, ErrorCode::kCorruptStream);
  const auto read = read_band_symbols(zeros, place(0), reader);
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, ErrorCode::kCorruptStream);
}

TEST_F(DetailSymbols, RejectsEveryTruncationAndExtension) {
  Bytes payload = written(bands_[0]);
  for (std::size_t size = 1; size < payload.size(); ++size) {
    DetailModel model;
    const auto band =
        read_band_symbols(Bytes(payload.data(), payload.data() + size), place(0), model);
    ASSERT_FALSE(band.has_value()) << size;
    EXPECT_EQ(band.error().code, ErrorCode::kCorruptStream);
  }
  payload.push_back(0);
  DetailModel model;
  EXPECT_FALSE(read_band_symbols(payload, place(0), model).has_value());
}

TEST_F(DetailSymbols, RefusesWhatCannotBeWritten) {
  const auto expect_refused = [&](const char* words, const auto& change) {
    BandSymbols bad = bands_[0];
    change(bad);
    DetailModel model;
    const auto payload = write_band_symbols(bad, place(0), model);
    ASSERT_FALSE(payload.has_value()) << words;
    EXPECT_EQ(payload.error().code, ErrorCode::kBadInput) << words;
    EXPECT_NE(payload.error().message.find(words), std::string::npos) << payload.error().message;
  };
  expect_refused("one point per detail", [](auto& b) { b.points.pop_back(); });
  expect_refused("past 2^24", [](auto& b) { b.points[1][2] = kMaxDetail + 1; });
  expect_refused("-8 .. 7", [](auto& b) { b.shrink_32nds[1] = 8; });
  expect_refused("0 .. 15", [](auto& b) { b.ratio_quarters = -1; });
}

}  // namespace
}  // namespace nacre::entropy
