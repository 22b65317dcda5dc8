// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/process.h"

#include <encage/error.h>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>

namespace encage::bench {

namespace {

// The first byte on the pipe says which of the two follows.
constexpr char output_tag = '+';
constexpr char error_tag = '-';

void write_all(int descriptor, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = write(descriptor, text.data() + done, text.size() - done);
    if (n < 0 && errno != EINTR) return;
    if (n > 0) done += static_cast<std::size_t>(n);
  }
}

std::string read_all(int descriptor) {
  std::string text;
  char buffer[65536];
  for (;;) {
    const ssize_t n = read(descriptor, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return text;
    text.append(buffer, static_cast<std::size_t>(n));
  }
}

[[noreturn]] void child(int descriptor, const std::function<std::string()>& work) {
  std::string message;
  try {
    message = output_tag + work();
  } catch (const std::exception& error) {
    message = std::string(1, error_tag) + error.what();
  }
  write_all(descriptor, message);
  // No destructors, no buffers flushed twice: the rest belongs to the parent.
  _exit(0);
}

}  // namespace

double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

ResidentMemory resident_memory() {
  std::ifstream status("/proc/self/status");
  ResidentMemory memory;
  for (std::string line; std::getline(status, line);) {
    const auto read = [&](const char* key, std::int64_t& bytes) {
      if (line.starts_with(key)) bytes = 1024 * std::stoll(line.substr(line.find(':') + 1));
    };
    read("VmRSS:", memory.total);
    read("RssAnon:", memory.anonymous);
    read("RssFile:", memory.file);
  }
  return memory;
}

void drop_from_cache(const std::vector<std::filesystem::path>& files) {
  for (const auto& file : files) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) continue;
    fdatasync(descriptor);
    posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
    close(descriptor);
  }
}

std::filesystem::path temporary_file(const std::string& name) {
  return std::filesystem::temp_directory_path() / (std::to_string(getpid()) + "-" + name);
}

ChildResult run_isolated(const std::function<std::string()>& work) {
  int ends[2];
  if (pipe(ends) != 0) throw Error(std::string("pipe: ") + std::strerror(errno));
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid < 0) throw Error(std::string("fork: ") + std::strerror(errno));
  if (pid == 0) {
    close(ends[0]);
    child(ends[1], work);
  }
  close(ends[1]);
  const std::string message = read_all(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;

  if (WIFSIGNALED(status)) return {"", std::string("crashed: ") + strsignal(WTERMSIG(status))};
  if (message.empty()) return {"", "the process ended without a result"};
  if (message[0] == error_tag) return {"", message.substr(1)};
  return {message.substr(1), ""};
}

}  // namespace encage::bench
