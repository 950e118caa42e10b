// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace nacre::entropy {

/// Stack-run coding [TsaiVillasenorChen1996] of a sequence of integers with many zeros, followed by
/// the adaptive arithmetic coder with two contexts (RUN: run symbols and the first symbol of a
/// stack; STACK: the rest). |value| < 2^62.
[[nodiscard]] std::vector<std::uint8_t> encode_stack_run(std::span<const std::int64_t> values);

/// Errors   kCorruptStream if the payload does not decode to exactly `count` values.
[[nodiscard]] Result<std::vector<std::int64_t>> decode_stack_run(std::span<const std::uint8_t> bytes,
                                                                 std::size_t count);

/// The symbol string over {'0','1','+','-'} that the arithmetic coder is given, for tests and docs.
[[nodiscard]] std::string stack_run_symbols(std::span<const std::int64_t> values);

}  // namespace nacre::entropy
