// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "app/batch/estimate.h"

namespace nacre::app::batch {
namespace {

/// Plays a schedule on a clock of its own: a job with k threads takes seconds / k.
struct Play {
  double end = 0;                ///< when the last job ended
  std::uint64_t peak_bytes = 0;  ///< of jobs that ran together
  int most_threads = 0, most_jobs = 0;
};

Play play(const std::vector<Job>& jobs, const Limits& limits) {
  Schedule schedule(jobs, limits);
  std::map<std::size_t, double> left;
  Play result;
  for (;;) {
    while (const auto job = schedule.start()) left[job->item] = job->seconds;
    if (left.empty()) break;
    std::uint64_t bytes = 0;
    int threads = 0;
    double step = 1e300;
    const auto shares = schedule.threads();
    for (const auto& share : shares) {
      threads += share.threads;
      bytes += jobs[share.item].bytes;
      step = std::min(step, left[share.item] / share.threads);
    }
    result.peak_bytes = std::max(result.peak_bytes, bytes);
    result.most_threads = std::max(result.most_threads, threads);
    result.most_jobs = std::max(result.most_jobs, static_cast<int>(shares.size()));
    result.end += step;
    for (const auto& share : shares) {
      left[share.item] -= step * share.threads;
      if (left[share.item] > 1e-9) continue;
      left.erase(share.item);
      schedule.finish(share.item);
    }
  }
  EXPECT_FALSE(schedule.waiting());
  return result;
}

TEST(Schedule, OneHugeAndManySmallFillTheMachine) {
  std::vector<Job> jobs = {{0, 300, 100}};
  for (std::size_t i = 1; i <= 100; ++i) jobs.push_back({i, 5, 1});
  for (const int threads : {1, 2, 4, 8}) {
    const Play result = play(jobs, {threads, threads, 1000});
    EXPECT_LE(result.end, 1.02 * 800 / threads) << threads;
    EXPECT_LE(result.most_threads, threads);
  }
}

TEST(Schedule, MemoryOfWhatRunsTogetherStaysBelowTheLimit) {
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < 40; ++i) {
      jobs.push_back({i, 1.0 + static_cast<double>(random() % 50), 10 + random() % 90});
    }
    const Play result = play(jobs, {8, 8, 200});
    EXPECT_LE(result.peak_bytes, 200u);
    EXPECT_LE(result.most_jobs, 8);
  }
}

TEST(Schedule, WhatNeverFitsRunsAlone) {
  const Play result = play({{0, 10, 500}, {1, 10, 50}, {2, 10, 50}}, {2, 2, 100});
  EXPECT_EQ(result.peak_bytes, 500u);
  EXPECT_EQ(play({{0, 10, 500}}, {4, 4, 100}).end, 2.5) << "it has all threads";
}

TEST(Schedule, FewerJobsThanThreadsShareThem) {
  Schedule schedule({{0, 30, 1}, {1, 10, 1}, {2, 5, 1}}, {2, 6, 100});
  EXPECT_EQ(schedule.start()->item, 0u);
  // Two thirds of the work is in the first one, which takes both slots ...
  EXPECT_TRUE(schedule.waiting());
  const auto shares = schedule.threads();
  int threads = 0;
  for (const auto& share : shares) threads += share.threads;
  EXPECT_EQ(threads, 6);
}

TEST(Schedule, MoreJobsThanThreadsHaveOneEach) {
  Schedule schedule({{0, 1, 1}, {1, 1, 1}, {2, 1, 1}}, {3, 1, 100});
  while (schedule.start()) {
  }
  const auto shares = schedule.threads();
  ASSERT_EQ(shares.size(), 3u);
  for (const auto& share : shares) EXPECT_EQ(share.threads, 1);
}

TEST(Schedule, RepeatedJobsWaitBehindTheOthersWithTheirNewSize) {
  Schedule schedule({{0, 9, 10}, {1, 5, 10}, {2, 4, 10}}, {1, 1, 100});
  EXPECT_EQ(schedule.start()->item, 0u);
  schedule.finish_and_repeat(0, 60);
  EXPECT_EQ(schedule.start()->item, 1u);
  schedule.finish(1);
  EXPECT_EQ(schedule.start()->item, 2u);
  schedule.finish(2);
  const auto last = schedule.start();
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->item, 0u);
  EXPECT_EQ(last->bytes, 60u);
}

TEST(Schedule, WhatIsSeenToUseMoreKeepsOthersOut) {
  Schedule schedule({{0, 9, 10}, {1, 9, 10}, {2, 9, 10}}, {3, 3, 40});
  EXPECT_TRUE(schedule.start().has_value());
  schedule.charge(0, 25);
  schedule.charge(0, 5);  // less than is known changes nothing
  EXPECT_TRUE(schedule.start().has_value());
  EXPECT_FALSE(schedule.start().has_value());
  schedule.finish(0);
  EXPECT_TRUE(schedule.start().has_value());
}

TEST(Shards, HoldEachItemOnceAndAreOfAboutEqualCost) {
  std::mt19937 random(3);
  Manifest manifest;
  for (int i = 0; i < 500; ++i) {
    Item item;
    item.triangles = 1000 + random() % 900'000;
    manifest.items.push_back(item);
  }
  double whole = 0, largest = 0;
  for (const Item& item : manifest.items) {
    whole += estimated_seconds(item);
    largest = std::max(largest, estimated_seconds(item));
  }
  for (const int count : {1, 2, 7, 64, 1000}) {
    std::vector<int> times(manifest.items.size(), 0);
    for (int shard = 0; shard < count; ++shard) {
      double cost = 0;
      for (const std::size_t i : shard_items(manifest, shard, count)) {
        ++times[i];
        cost += estimated_seconds(manifest.items[i]);
      }
      EXPECT_LE(cost, whole / count + largest) << shard << '/' << count;
    }
    EXPECT_EQ(std::ranges::count(times, 1), 500) << count;
  }
}

}  // namespace
}  // namespace nacre::app::batch
