// SPDX-License-Identifier: GPL-3.0-or-later
//
// Learns entropy/detail_start.cpp from streams of profile best, and writes it to stdout:
//   learn_starts FILE.ncr...
// A counter starts from what it has come to after all the streams, one after another.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "codec/stream_reader.h"
#include "entropy/connectivity.h"
#include "entropy/detail_coder.h"
#include "entropy/detail_start.h"
#include "io/write.h"

namespace nacre::bench {
namespace {

/// Bits that must have been seen.
constexpr std::uint32_t kLeastCount = 4;

template <class T>
T expect(Result<T> result, const char* file) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}: {}\n", file, result.error().message);
  std::exit(1);
}

/// Sends all bands of a stream through the model.
void learn(const char* file, entropy::DetailModel& model) {
  const auto bytes = expect(io::read_file(file), file);
  const auto layout = expect(codec::read_layout(bytes), file);
  const auto payload = expect(codec::read_section(bytes, layout.sections[0]), file);
  const auto triangles = static_cast<std::uint32_t>(layout.header.base_triangles);
  const auto base = expect(entropy::decode_connectivity(payload, triangles), file);
  const auto topology = expect(
      Topology::build_for_decoding(base.triangles, base.vertex_count, layout.header.levels), file);
  // The model that decodes is the file's own; the other one is shown what it decoded.
  entropy::DetailModel own;
  const codec::BandEntry* coarser = nullptr;
  for (std::size_t j = 0; j < layout.header.bands.size(); ++j) {
    const codec::BandEntry& entry = layout.header.bands[j];
    const bool is_coded = entry.payload_bytes > 0;
    const int level = static_cast<int>(j);
    const entropy::BandPlace place{
        &topology.level(level), level > 0 ? &topology.level(level - 1) : nullptr, level,
        coarser != nullptr && is_coded ? coarser->step_index - entry.step_index : 0};
    coarser = is_coded ? &entry : nullptr;
    const auto band_bytes = expect(codec::read_section(bytes, layout.sections[2 + j]), file);
    const auto band = expect(entropy::decode_details(band_bytes, place, own), file);
    entropy::show_details(band, is_coded, place, model);
  }
}

int main_of(int argc, char** argv) {
  entropy::DetailModel model(entropy::DetailModel::Start::kBlank);
  for (int i = 1; i < argc; ++i) learn(argv[i], model);
  fmt::print(
      "// SPDX-License-Identifier: Apache-2.0\n#include \"entropy/detail_start.h\"\n\n"
      "namespace nacre::entropy {{\n\n"
      "// Written by bench/learn_starts; see docs/decisions/0004-best-profile.md.\n"
      "// clang-format off\n"
      "const std::array<std::int8_t, kCounterStarts> kStarts = {{");
  std::size_t column = 0;
  for (const entropy::BitCounter& counter : model.counters()) {
    if (column++ % 24 == 0) fmt::print("\n   ");
    const int start = std::clamp(entropy::stretch(counter.probability()) / 32, -88, 88);
    if (counter.count() < kLeastCount) {
      fmt::print(" 99,");
    } else {
      fmt::print(" {},", start);
    }
  }
  fmt::print("\n}};\n// clang-format on\n\n}}  // namespace nacre::entropy\n");
  return 0;
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
