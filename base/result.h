// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace nacre {

/// What went wrong, in the kinds a caller can act on. `app/` maps each kind to one exit code.
enum class ErrorCode : std::uint8_t {
  kBadInput,            ///< the caller's mesh or option breaks a documented requirement
  kUnreadableFile,      ///< a file is missing, unreadable or of no known format
  kGeometryRefused,     ///< the scan cannot be processed under the chosen repair policy
  kGoalUnreachable,     ///< no output meets the asked-for size, error or quality
  kCorruptStream,       ///< bytes that no encoder of this version writes
  kUnsupportedVersion,  ///< well-formed, but newer than this decoder
  kLimitExceeded,       ///< would need more than the limits allow
  kNoConvergence,       ///< an iteration stopped before its tolerance
  kCannotWrite,         ///< an output cannot be created, written or renamed
  kCancelled,           ///< the caller asked to stop
};

struct Error {
  ErrorCode code = ErrorCode::kBadInput;
  std::string message;    ///< for a person: what was expected, what was found, what to do
  std::size_t where = 0;  ///< byte offset in a file or stream, or element index in a mesh
};

/// A value or the reason there is none; in shape `std::expected<T, Error>`, which C++20 lacks.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(*-explicit-*)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(*-explicit-*)

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  T& value() & { return checked(); }
  const T& value() const& { return const_cast<Result*>(this)->checked(); }
  T&& value() && { return std::move(checked()); }
  T& operator*() & { return checked(); }
  const T& operator*() const& { return const_cast<Result*>(this)->checked(); }
  T&& operator*() && { return std::move(checked()); }
  T* operator->() { return &checked(); }
  const T* operator->() const { return &const_cast<Result*>(this)->checked(); }

  [[nodiscard]] const Error& error() const {
    assert(!has_value());
    return *std::get_if<1>(&state_);
  }

 private:
  T& checked() {
    assert(has_value());
    return *std::get_if<0>(&state_);
  }
  std::variant<T, Error> state_;
};

/// Success, or the reason for failure, of something that returns nothing.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT(*-explicit-*)
  [[nodiscard]] bool has_value() const { return !error_; }
  explicit operator bool() const { return has_value(); }
  [[nodiscard]] const Error& error() const {
    assert(error_);
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace nacre
