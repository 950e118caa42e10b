// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

namespace nacre {

/// Allocator of memory that is zeros already: std::vector<T, ZeroedAllocator<T>>(n) touches none of
/// it, and what is never looked at never costs a page. For types whose value-initialised state is
/// all zeros, in vectors that are made in one size: one that shrinks and grows again finds what was
/// there before.
template <class T>
struct ZeroedAllocator {
  static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 64);
  using value_type = T;

  ZeroedAllocator() = default;
  template <class U>
  ZeroedAllocator(const ZeroedAllocator<U>&) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] T* allocate(std::size_t count) {
    if (count > std::numeric_limits<std::size_t>::max() / sizeof(T) / 2)
      throw std::bad_array_new_length();
    void* const memory = std::calloc(count * sizeof(T) + kAlignment, 1);
    if (memory == nullptr) throw std::bad_alloc();
    // On a cache line's start, with what calloc() gave just before it.
    const auto address = reinterpret_cast<std::uintptr_t>(memory);
    auto* const start = static_cast<char*>(memory) + (kAlignment - address % kAlignment);
    std::memcpy(start - sizeof memory, &memory, sizeof memory);
    return reinterpret_cast<T*>(start);
  }
  void deallocate(T* start, std::size_t) {
    void* memory = nullptr;
    std::memcpy(&memory, reinterpret_cast<char*>(start) - sizeof memory, sizeof memory);
    std::free(memory);
  }

  /// Value-initialisation finds its zeros there.
  template <class U>
  void construct(U*) {}
  template <class U, class First, class... Rest>
  void construct(U* place, First&& first, Rest&&... rest) {
    ::new (static_cast<void*>(place)) U(std::forward<First>(first), std::forward<Rest>(rest)...);
  }

  friend bool operator==(const ZeroedAllocator&, const ZeroedAllocator&) { return true; }

 private:
  static constexpr std::size_t kAlignment = 64;
};

}  // namespace nacre
