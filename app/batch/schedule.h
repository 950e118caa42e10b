// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace nacre::app::batch {

/// A scan to encode, as the scheduler sees it.
struct Job {
  std::size_t item = 0;
  double seconds = 0;       ///< expected, on one thread
  std::uint64_t bytes = 0;  ///< expected peak
};

struct Limits {
  int jobs = 1;             ///< at once
  int threads = 1;          ///< of all of them together
  std::uint64_t bytes = 0;  ///< of all of them together
};

/// Which scan starts next, and with how many threads; pure bookkeeping.
///
/// Longest first, as far as it fits into the memory left, because a long one begun last leaves the
/// other cores idle. One thread for each is the cheapest way to fill the cores. More go to (1) a
/// scan so long that it would still run when all others are done, from its start, and (2) the
/// longest running ones whenever nothing else can start, as at the end of a batch.
///
/// Ensures  (1) the expected bytes of what runs are within the limit, unless one runs alone
///          (2) at most `jobs` run, and with threads() together on at most `threads`, or on one
///          each
///              if jobs > threads
///          (3) something can start whenever nothing runs and not all is done
class Schedule {
 public:
  Schedule(std::vector<Job> jobs, const Limits& limits);

  /// The next to start now, which then counts as running; none: wait for one to finish.
  [[nodiscard]] std::optional<Job> start();
  void finish(std::size_t item);
  /// Ends a running one and puts it behind all that wait, to need `bytes` this time.
  void finish_and_repeat(std::size_t item, std::uint64_t bytes);
  /// What a running one was seen to use, if that is more than expected of it.
  void charge(std::size_t item, std::uint64_t bytes);
  void drop_waiting() { waiting_.clear(); }

  /// Threads of each running scan, in the order of starting.
  struct Share {
    std::size_t item = 0;
    int threads = 1;
  };
  [[nodiscard]] std::vector<Share> threads() const;
  [[nodiscard]] bool waiting() const { return !waiting_.empty(); }

 private:
  struct Running {
    Job job;
    int slots = 1;  ///< of Limits::jobs
  };
  [[nodiscard]] Job take(std::size_t item);

  std::vector<Job> waiting_;
  std::vector<Running> running_;
  Limits limits_;
  double unfinished_seconds_ = 0;
  std::uint64_t used_bytes_ = 0;
  int used_slots_ = 0;
};

}  // namespace nacre::app::batch
