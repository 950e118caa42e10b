// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <variant>
#include <vector>

#include "app/allocator.h"
#include "app/batch/verbs.h"
#include "app/cli.h"
#include "app/exit_code.h"
#include "app/interrupt.h"
#include "app/memory_guard.h"
#include "app/progress.h"
#include "app/verbs.h"

namespace nacre::app {
namespace {

Result<void> dispatch(const EncodeCommand& c, Console& console) { return run_encode(c, console); }
Result<void> dispatch(const DecodeCommand& c, Console& console) { return run_decode(c, console); }
Result<void> dispatch(const CutCommand& c, Console& console) { return run_cut(c, console); }
Result<void> dispatch(const RemeshCommand& c, Console& console) { return run_remesh(c, console); }
Result<void> dispatch(const CompareCommand& c, Console& console) { return run_compare(c, console); }
Result<void> dispatch(const InfoCommand& c, Console& console) { return run_info(c, console); }
Result<void> dispatch(const StageCommand& c, Console& console) { return run_stage(c, console); }

/// A batch that got through can still have scans that failed, and that is its exit code.
Result<int> dispatch_with_code(const BatchCommand& c, Console& console) {
  return batch::run_batch(c.verb, console);
}
template <class C>
Result<int> dispatch_with_code(const C& c, Console& console) {
  if (Result<void> done = dispatch(c, console); !done) return done.error();
  return int{kExitDone};
}

/// The default honours the affinity mask, and so a batch system's share of the machine.
std::size_t thread_count(const Common& common) {
  return static_cast<std::size_t>(common.threads > 0 ? common.threads
                                                     : tbb::info::default_concurrency());
}

Result<int> run(const Command& command) {
  const std::atomic<bool>& cancel = install_interrupt_handler();
  return std::visit(
      [&](const auto& c) -> Result<int> {
        if constexpr (std::is_same_v<std::decay_t<decltype(c)>, PrintText>) {
          std::fputs(c.text.c_str(), stdout);
          return int{kExitDone};
        } else {
          const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                            thread_count(c.common));
          Console console(c.common.verbosity, cancel, c.common.progress);
          const MemoryGuard guard(c.common.max_memory_bytes);
          Result<int> done = dispatch_with_code(c, console);
          if (!done && guard.exceeded()) return guard.error();
          return done;
        }
      },
      command);
}

int fail(const Error& error) {
  std::fprintf(stderr, "nacre: %s\n", error.message.c_str());
  return exit_code(error.code);
}

int run_main(const std::vector<std::string>& arguments) {
  set_up_allocator();
  const Result<Command> command = parse_command_line(arguments);
  if (!command) return fail(command.error());
  const Result<int> done = run(*command);
  if (!done) return fail(done.error());
  // A full disk under a redirected stdout shows up here at the latest.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    return fail({ErrorCode::kCannotWrite, "standard output could not be written"});
  }
  return *done;
}

}  // namespace
}  // namespace nacre::app

int main(int argc, char** argv) {
  try {
    return nacre::app::run_main(std::vector<std::string>(argv + (argc > 0 ? 1 : 0), argv + argc));
  } catch (const std::bad_alloc&) {
    std::fputs("nacre: out of memory; try fewer --levels, or a machine with more\n", stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "nacre: unexpected failure: %s\n", error.what());
  }
  return nacre::app::kExitUnexpected;
}
