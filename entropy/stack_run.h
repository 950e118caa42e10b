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
/// stack; STACK: the rest). |value| < 2^62. The exact rules are in README.md.
///
/// Ensures  (1) only zeros, or no values at all, take no bytes
///          (2) for one count, no payload but that of (1) is a proper prefix of another
[[nodiscard]] std::vector<std::uint8_t> encode_stack_run(std::span<const std::int64_t> values);

/// Ensures  accepted if and only if encode_stack_run() writes exactly `bytes` for the result.
/// Errors   kCorruptStream if the payload does not decode to exactly `count` values, is cut short
/// or
///          has bytes left; `where` is the index of the value. Allocates in proportion to `count`,
///          which is the caller's to check (zeros take no bytes, so the payload bounds nothing).
[[nodiscard]] Result<std::vector<std::int64_t>> decode_stack_run(
    std::span<const std::uint8_t> bytes, std::size_t count);

/// The symbol string over {'0','1','+','-'} that the arithmetic coder is given, for tests and docs.
[[nodiscard]] std::string stack_run_symbols(std::span<const std::int64_t> values);

}  // namespace nacre::entropy
