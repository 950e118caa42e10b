// SPDX-License-Identifier: Apache-2.0
#include "codec/push_reader.h"

#include <algorithm>
#include <new>
#include <string>
#include <utility>

#include "codec/level_decoder.h"
#include "codec/stream_reader.h"

namespace nacre::codec {

struct PushReader::State {
  std::vector<std::uint8_t> bytes;  // those at [begin, begin + size) of the stream
  std::size_t begin = 0;
  std::size_t received = 0;  // of the stream, skipped ones included
  std::optional<StreamLayout> layout;
  int finest = 0;  // the level wanted
  std::unique_ptr<LevelDecoder> decoder;
  std::optional<Error> error;

  [[nodiscard]] bool has(const SectionRange& section) const {
    return section.end() <= begin + bytes.size();
  }
  /// Payload of a section that is there.
  [[nodiscard]] Result<std::span<const std::uint8_t>> payload(const SectionRange& section) const {
    const auto from = std::span(bytes).subspan(section.offset - begin);
    return checked_payload(from.first(section.end() - section.offset), section);
  }
  void forget_before(std::size_t offset) {
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(offset - begin));
    begin = offset;
  }
};

PushReader::PushReader(const DecodeOptions& options)
    : options_(options), state_(std::make_unique<State>()) {}
PushReader::~PushReader() = default;
PushReader::PushReader(PushReader&&) noexcept = default;
PushReader& PushReader::operator=(PushReader&&) noexcept = default;

int PushReader::level() const { return state_->decoder ? mesh()->level_count : -1; }

bool PushReader::done() const { return state_->decoder && level() == state_->finest; }

const SemiRegularMesh* PushReader::mesh() const {
  return state_->decoder ? &state_->decoder->mesh() : nullptr;
}

Result<void> PushReader::fail(Error error) {
  state_->error = std::move(error);
  return *state_->error;
}

void PushReader::reached(const OnLevel& on_level) const {
  if (on_level) on_level(*mesh());
}

Result<void> PushReader::push(std::span<const std::uint8_t> bytes, const OnLevel& on_level) try {
  State& state = *state_;
  if (state.error) return *state.error;
  state.received += bytes.size();
  if (!done()) state.bytes.insert(state.bytes.end(), bytes.begin(), bytes.end());
  if (!state.layout) {
    if (const auto ok = read_header(); !ok) return fail(ok.error());
    if (!state.layout) return {};
  }
  if (state.received > state.layout->bytes_whole()) {
    const std::size_t whole = state.layout->bytes_whole();
    return fail({ErrorCode::kCorruptStream,
                 "there are bytes after the stream's end (byte " + std::to_string(whole) + ")",
                 whole});
  }
  while (!done()) {
    const auto more = read_next(on_level);
    if (!more) return fail(more.error());
    if (!*more) return {};
  }
  state.bytes = {};
  return {};
} catch (const std::bad_alloc&) {
  return fail({ErrorCode::kLimitExceeded, "not enough memory for the stream's mesh", 0});
}

Result<void> PushReader::read_header() {
  State& state = *state_;
  auto layout = try_read_layout(state.bytes);
  if (!layout) return layout.error();
  if (!*layout) return {};
  const int levels = (*layout)->header.levels;
  state.finest = options_.max_level < 0 ? levels : std::min(options_.max_level, levels);
  const auto counts = level_counts((*layout)->header);
  const std::uint64_t vertices = counts[static_cast<std::size_t>(state.finest)].vertices;
  if (vertices > options_.max_vertices) {
    return Error{ErrorCode::kLimitExceeded,
                 "the stream decodes to " + std::to_string(vertices) + " vertices, the limit is " +
                     std::to_string(options_.max_vertices),
                 6};
  }
  auto info = inspect_header(state.bytes, (*layout)->bytes_whole());
  if (!info) return info.error();
  info_ = std::move(*info);
  state.layout = std::move(*layout);
  return {};
}

/// Whether a level more is there now.
Result<bool> PushReader::read_next(const OnLevel& on_level) {
  if (!state_->decoder) return read_base(on_level);
  if (is_comparator(state_->layout->header.profile)) return read_comparator(on_level);
  return read_band(on_level);
}

Result<bool> PushReader::read_base(const OnLevel& on_level) {
  State& state = *state_;
  const std::vector<SectionRange>& sections = state.layout->sections;
  if (!state.has(sections[1])) return false;
  const auto connectivity = state.payload(sections[0]);
  if (!connectivity) return connectivity.error();
  const auto positions = state.payload(sections[1]);
  if (!positions) return positions.error();
  auto decoder = LevelDecoder::begin(*state.layout, *connectivity, *positions, state.finest);
  if (!decoder) return decoder.error();
  state.decoder = std::move(*decoder);
  if (!is_comparator(state.layout->header.profile)) state.forget_before(sections[1].end());
  reached(on_level);
  return true;
}

Result<bool> PushReader::read_band(const OnLevel& on_level) {
  State& state = *state_;
  const std::size_t section = 2 + static_cast<std::size_t>(level());
  Result<std::span<const std::uint8_t>> payload = std::span<const std::uint8_t>();
  if (section < state.layout->sections.size()) {
    const SectionRange& range = state.layout->sections[section];
    if (!state.has(range)) return false;
    payload = state.payload(range);
    if (!payload) return payload.error();
  }
  if (const auto ok = state.decoder->next_level(*payload); !ok) return ok.error();
  if (section < state.layout->sections.size())
    state.forget_before(state.layout->sections[section].end());
  reached(on_level);
  return true;
}

Result<bool> PushReader::read_comparator(const OnLevel& on_level) {
  State& state = *state_;
  if (state.begin + state.bytes.size() < state.layout->bytes_whole()) return false;
  if (options_.comparators == nullptr) {
    return Error{ErrorCode::kUnsupportedVersion,
                 "the stream is of profile " +
                     std::string(profile_name(state.layout->header.profile)) +
                     ", which this decoder does not have",
                 5};
  }
  const auto bands = options_.comparators(state.bytes, *state.layout, state.decoder->topology(),
                                          state.finest, options_.max_vertices);
  if (!bands) return bands.error();
  for (const std::vector<Vec3>& details : *bands)
    if (const auto ok = state.decoder->next_level(details); !ok) return ok.error();
  reached(on_level);
  return true;
}

Result<void> PushReader::finish() const {
  const State& state = *state_;
  if (state.error) return *state.error;
  if (done() || (options_.accept_prefix && state.decoder)) return {};
  std::string what = "the stream is cut before the end of the base mesh";
  if (state.decoder) {
    what = "the stream is cut: " + std::to_string(state.layout->bytes_whole()) + " bytes expected";
  }
  return Error{ErrorCode::kCorruptStream, what + " (byte " + std::to_string(state.received) + ")",
               state.received};
}

}  // namespace nacre::codec
