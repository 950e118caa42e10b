// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/zeroed_allocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace nacre {
namespace {

using Item = std::array<std::uint32_t, 8>;
using Items = std::vector<Item, ZeroedAllocator<Item>>;

TEST(ZeroedAllocator, IsZeroAndStartsACacheLine) {
  // Memory that was written and given back before is zero again, too.
  for (const std::size_t count : {1u, 7u, 100u, 100u, 70'000u, 70'000u, 100u}) {
    Items items(count);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(items.data()) % 64, 0u);
    EXPECT_TRUE(std::all_of(items.begin(), items.end(), [](const Item& i) { return i == Item{}; }));
    std::fill(items.begin(), items.end(), Item{1, 2, 3, 4, 5, 6, 7, 8});
  }
}

TEST(ZeroedAllocator, CopiesAndGrowsLikeAnyOther) {
  Items items(3);
  items[1][2] = 5;
  Items copy = items;
  copy.push_back(Item{9});
  copy.resize(100);
  EXPECT_EQ(copy[1][2], 5u);
  EXPECT_EQ(copy[3][0], 9u);
  EXPECT_EQ(copy[99], Item{});
  EXPECT_EQ(items.size(), 3u);
}

TEST(ZeroedAllocator, RefusesMoreThanThereIs) {
  ZeroedAllocator<Item> allocator;
  EXPECT_THROW(static_cast<void>(allocator.allocate(~std::size_t{0} / 32)), std::bad_alloc);
}

}  // namespace
}  // namespace nacre
