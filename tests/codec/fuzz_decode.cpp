// SPDX-License-Identifier: Apache-2.0
//
// libFuzzer entry for the decoder. Checksums would stop nearly every mutation at the door, so each
// input is also tried with its checksums put right: that is what reaches the section decoders.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "codec/decode.h"
#include "codec/push_reader.h"
#include "codec/stream_format.h"
#include "codec/stream_reader.h"

namespace {

using Bytes = std::vector<std::uint8_t>;
namespace codec = nacre::codec;

/// A stream that decodes gives the same piece by piece; but a reader, which cannot know how far the
/// bytes will come, holds the limit against the finest level.
void push_in_pieces(const Bytes& bytes, const codec::DecodeOptions& options,
                    const nacre::Result<nacre::SemiRegularMesh>& decoded) {
  codec::PushReader reader(options);
  constexpr std::size_t kPiece = 11;
  nacre::Result<void> ok;
  for (std::size_t at = 0; ok && at < bytes.size(); at += kPiece)
    ok = reader.push(std::span(bytes).subspan(at, std::min(kPiece, bytes.size() - at)));
  if (ok) ok = reader.finish();
  if (!ok && ok.error().code == nacre::ErrorCode::kLimitExceeded) return;
  if (ok.has_value() != decoded.has_value()) std::abort();
  if (ok && reader.mesh()->positions != decoded->positions) std::abort();
}

void decode_every_way(const Bytes& bytes) {
  codec::DecodeOptions options;
  options.max_vertices = 1 << 14;
  const auto info = codec::inspect(bytes, options);
  const auto mesh = codec::decode(bytes, options);
  if (mesh && !info) std::abort();
  if (mesh && mesh->positions.size() != info->levels.back().vertices) std::abort();
  options.accept_prefix = true;
  const auto prefix = codec::decode(bytes, options);
  if (mesh && !prefix) std::abort();
  push_in_pieces(bytes, options, prefix);
  options.max_level = 0;
  (void)codec::decode(bytes, options);
}

void put(Bytes& bytes, std::size_t offset, std::uint64_t value, std::size_t width) {
  for (std::size_t i = 0; i < width && offset + i < bytes.size(); ++i)
    bytes[offset + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

/// Where a header could end is tried byte by byte; false if it ends nowhere.
bool repair_checksums(Bytes& bytes) {
  constexpr std::size_t kLongestHeader = 256;
  for (std::size_t end = 6; end + 2 <= std::min(bytes.size(), kLongestHeader); ++end) {
    Bytes trial = bytes;
    put(trial, end, codec::crc16(std::span(trial).first(end)), 2);
    const auto layout = codec::read_layout(trial);
    if (!layout || layout->header_bytes != end + 2) continue;
    for (const codec::SectionRange& s : layout->sections) {
      if (s.end() > trial.size()) break;
      const auto payload = std::span(trial).subspan(s.offset, s.payload_bytes);
      const std::size_t width = codec::checksum_bytes(s.payload_bytes);
      put(trial, s.offset + s.payload_bytes,
          width == 2 ? codec::crc16(payload) : codec::crc32c(payload), width);
    }
    bytes = std::move(trial);
    return true;
  }
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > (1 << 16)) return 0;
  Bytes bytes(data, data + size);
  decode_every_way(bytes);
  if (repair_checksums(bytes)) decode_every_way(bytes);
  return 0;
}
