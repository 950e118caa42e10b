// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/write.h"
#include "scratch.h"
#include "support/shapes.h"

/// Runs the built command as a user would.
namespace nacre::app::test {

struct Outcome {
  int exit_code = -1;  ///< -1 if it was killed by a signal
  std::string out, err;
};

/// A running command; its streams go to files in a folder of their own.
class Running {
 public:
  explicit Running(const std::vector<std::string>& arguments) {
    std::vector<char*> argv = {const_cast<char*>(NACRE_COMMAND)};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    const std::string out = streams_.file("out").string(), err = streams_.file("err").string();
    pid_ = fork();
    if (pid_ < 0) throw std::runtime_error("fork failed");
    if (pid_ == 0) {
      dup2(open(out.c_str(), O_CREAT | O_WRONLY, 0600), STDOUT_FILENO);
      dup2(open(err.c_str(), O_CREAT | O_WRONLY, 0600), STDERR_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
  }

  /// True once the command has a handler for SIGINT; false if it ended before.
  [[nodiscard]] bool wait_until_interruptible() const {
    for (;;) {
      std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
      bool running = false;
      for (std::string line; std::getline(status, line);) {
        if (line.starts_with("State:")) running = line.find('Z') == std::string::npos;
        if (!line.starts_with("SigCgt:")) continue;
        if ((std::stoull(line.substr(7), nullptr, 16) >> (SIGINT - 1)) & 1) return true;
      }
      if (!running) return false;
      usleep(500);
    }
  }
  void interrupt() const { kill(pid_, SIGINT); }

  /// SIGKILL, and its end. False if it had ended before.
  bool kill_hard() {
    kill(pid_, SIGKILL);
    int status = 0;
    waitpid(pid_, &status, 0);
    return WIFSIGNALED(status);
  }

  Outcome wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, streams_.read("out"),
            streams_.read("err")};
  }

 private:
  Scratch streams_;
  pid_t pid_ = -1;
};

inline Outcome run(const std::vector<std::string>& arguments) { return Running(arguments).wait(); }

/// Writes a mesh in the format that the name says.
inline void save(const Scratch& scratch, const std::string& name, const Scan& scan) {
  const auto format = io::mesh_format(name);
  const auto bytes = io::serialize_mesh(scan, format.value());
  scratch.write(name, std::string(bytes.value().begin(), bytes.value().end()));
}

}  // namespace nacre::app::test
