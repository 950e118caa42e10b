// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "app/goal.h"
#include "app/progress.h"
#include "app/report.h"
#include "codec/codec.h"
#include "metric/metric.h"

/// From a semi-regular mesh to the file that a goal asks for, by coding, decoding and measuring.
namespace nacre::app {

/// How far over its goal a PSNR may be, dB.
inline constexpr double kPsnrTolerance = 0.1;

/// The scan as everything is measured against it.
struct Reference {
  const Scan& scan;
  const metric::Surface& surface;
  std::vector<Vec3> places = {};  ///< on it, that count for the maximum error beside the samples
};

/// A file, decoded and measured.
struct Coded {
  codec::EncodeOptions options;  ///< that the file was made with
  codec::Encoded encoded;
  metric::Comparison distance;
  std::optional<metric::Certified> certified;  ///< of goals on the maximum error
  std::uint64_t size_limit = 0;                ///< of the whole file, of goals that have one
  bool reached = true;
  /// What a person should know: how near it came, or that more bytes gain nothing.
  std::string remark;

  [[nodiscard]] double maximum_error() const;
};

/// As many as it takes.
inline constexpr std::size_t kAnyBytes = std::numeric_limits<std::size_t>::max();

/// Bytes that a file of this target and so many levels has to keep free.
using Reserve = std::function<std::size_t(std::uint64_t target_bytes, int levels)>;

/// The file for a goal, or with `reached` false the nearest that this mesh allows. A PSNR is met
/// within 0.1 dB and a maximum error is certified, both by search; a size holds by itself. A search
/// ends where a file of `useful_bytes` does not reach the goal: then that is the nearest.
///
/// Errors   kGoalUnreachable: not even the base mesh fits; `where` is the size it needs. Others as
///          codec::encode, metric::compare; kCancelled.
[[nodiscard]] Result<Coded> code_for_goal(const EncodeCommand& command, const InputFacts& input,
                                          const SemiRegularMesh& mesh, Reference& reference,
                                          const Reserve& reserve, Console& console,
                                          std::size_t useful_bytes = kAnyBytes);

/// The same for what was coded already.
[[nodiscard]] Result<Coded> measured(const EncodeCommand& command, Result<codec::Encoded> encoded,
                                     const Reference& reference, Console& console);

/// Bounds of the maximum error. Above `give_up_above`, model units, they may be loose.
[[nodiscard]] Result<metric::Certified> certify(
    const Reference& reference, const Coded& coded, Console& console,
    double give_up_above = std::numeric_limits<double>::infinity());

/// Of any profile.
[[nodiscard]] codec::DecodeOptions decoding_options();

}  // namespace nacre::app
