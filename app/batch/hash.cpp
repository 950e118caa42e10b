// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/hash.h"

#define XXH_INLINE_ALL
#include <fmt/format.h>
#include <xxhash.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <vector>

namespace nacre::app::batch {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

std::string digits(const XXH128_hash_t& hash) {
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace

std::string hash_of(std::string_view bytes) {
  return digits(XXH3_128bits(bytes.data(), bytes.size()));
}

Result<std::string> hash_file(const std::filesystem::path& file) {
  const auto failed = [&] {
    return Error{ErrorCode::kUnreadableFile,
                 fmt::format("{}: {}", file.string(), std::generic_category().message(errno))};
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           &std::fclose);
  if (!in) return failed();
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                              &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<char> chunk(kChunkBytes);
  std::setvbuf(in.get(), nullptr, _IONBF, 0);
  while (const std::size_t got = std::fread(chunk.data(), 1, chunk.size(), in.get())) {
    XXH3_128bits_update(state.get(), chunk.data(), got);
  }
  if (std::ferror(in.get()) != 0) return failed();
  return digits(XXH3_128bits_digest(state.get()));
}

}  // namespace nacre::app::batch
