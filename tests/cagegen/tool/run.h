// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace encage::test {

/// How a program ended and what it printed.
struct RunResult {
  int status = -1;  ///< exit status; 128 + signal if a signal ended it
  std::string out;
  std::string err;
};

/// A program running with its output going to files; waited for, or killed, at the end.
class Process {
 public:
  /// Starts `command` (program, then arguments) in `folder`, its standard input empty.
  Process(const std::vector<std::string>& command, const std::filesystem::path& folder);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool running();
  /// Whether it has a handler for this signal; false once it has ended.
  bool catches(int number) const;
  void signal(int number) const;
  RunResult wait();

 private:
  void reap(int options);

  pid_t pid_ = -1;
  bool ended_ = false;
  int status_ = -1;
  std::filesystem::path output_;  // a folder of its own, not the one it runs in
};

/// Starts and waits.
RunResult run(const std::vector<std::string>& command, const std::filesystem::path& folder);

/// A new empty folder, removed with everything in it at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Names of what is in it, sorted.
  std::vector<std::string> names() const;
  std::filesystem::path write(const std::string& name, const std::string& bytes) const;
  std::string read(const std::string& name) const;

 private:
  std::filesystem::path path_;
};

}  // namespace encage::test
