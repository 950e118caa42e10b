// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/schedule.h"

#include <algorithm>
#include <cassert>
#include <functional>

namespace nacre::app::batch {

Schedule::Schedule(std::vector<Job> jobs, const Limits& limits)
    : waiting_(std::move(jobs)), limits_(limits) {
  std::ranges::stable_sort(waiting_, std::greater<>(), &Job::seconds);
  for (const Job& job : waiting_) unfinished_seconds_ += job.seconds;
}

std::optional<Job> Schedule::start() {
  const int free_slots = limits_.jobs - used_slots_;
  if (free_slots < 1) return std::nullopt;
  const auto fits = [&](const Job& job) {
    return running_.empty() || used_bytes_ + job.bytes <= limits_.bytes;
  };
  const auto found = std::ranges::find_if(waiting_, fits);
  if (found == waiting_.end()) return std::nullopt;
  const Job job = *found;
  waiting_.erase(found);
  // Its share of all the work that is left, rounded down: with less it would be the last to end.
  const double share = unfinished_seconds_ > 0 ? job.seconds / unfinished_seconds_ : 0;
  const int slots = std::clamp(static_cast<int>(share * limits_.jobs), 1, free_slots);
  running_.push_back({job, slots});
  used_slots_ += slots;
  used_bytes_ += job.bytes;
  return job;
}

Job Schedule::take(std::size_t item) {
  const auto found =
      std::ranges::find_if(running_, [&](const Running& r) { return r.job.item == item; });
  assert(found != running_.end());
  const Running ended = *found;
  running_.erase(found);
  used_slots_ -= ended.slots;
  used_bytes_ -= ended.job.bytes;
  return ended.job;
}

void Schedule::finish(std::size_t item) { unfinished_seconds_ -= take(item).seconds; }

void Schedule::finish_and_repeat(std::size_t item, std::uint64_t bytes) {
  Job job = take(item);
  job.bytes = bytes;
  waiting_.push_back(job);
}

void Schedule::charge(std::size_t item, std::uint64_t bytes) {
  for (Running& running : running_) {
    if (running.job.item != item || running.job.bytes >= bytes) continue;
    used_bytes_ += bytes - running.job.bytes;
    running.job.bytes = bytes;
  }
}

std::vector<Schedule::Share> Schedule::threads() const {
  std::vector<Share> shares;
  for (const Running& running : running_) shares.push_back({running.job.item, 1});
  for (int spare = limits_.threads - static_cast<int>(shares.size()); spare > 0 && !shares.empty();
       --spare) {
    // To the one whose threads have most work each; of equals, to the one that started first.
    std::size_t neediest = 0;
    const auto load = [&](std::size_t i) { return running_[i].job.seconds / shares[i].threads; };
    for (std::size_t i = 1; i < shares.size(); ++i) {
      if (load(i) > load(neediest)) neediest = i;
    }
    ++shares[neediest].threads;
  }
  return shares;
}

}  // namespace nacre::app::batch
