// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What benches ask of the operating system. POSIX calls stand in process.cpp and nowhere else in bench/.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace encage::bench {

/// CPU seconds that the calling thread has used.
double thread_cpu_seconds();

/// Memory of this process that is resident now, in bytes; 0 where the system does not say.
struct ResidentMemory {
  std::int64_t total = 0;
  std::int64_t anonymous = 0;  ///< heap and stacks
  std::int64_t file = 0;       ///< mapped files
};
ResidentMemory resident_memory();

/// Asks the system to drop the files from its cache, as far as no process has mapped them.
void drop_from_cache(const std::vector<std::filesystem::path>& files);

/// A file name in the folder for temporary files that no other process uses.
std::filesystem::path temporary_file(const std::string& name);

/// How a child process ended.
struct ChildResult {
  std::string output;  ///< what `work` returned; empty if it did not end well
  std::string error;   ///< empty if it ended well
};

/// Runs `work` in a forked child and returns its string: neither a crash nor a leak of it reaches the caller. What
/// `work` throws becomes `error`. Call only while this process has one thread.
ChildResult run_isolated(const std::function<std::string()>& work);

}  // namespace encage::bench
