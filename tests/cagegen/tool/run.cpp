// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/run.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <system_error>

namespace encage::test {

namespace fs = std::filesystem;

namespace {

fs::path make_folder() {
  std::string name = (fs::temp_directory_path() / "encage-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
  return name;
}

std::string read_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot read");
  return {std::istreambuf_iterator<char>(in), {}};
}

void redirect(int descriptor, const fs::path& file, int flags) {
  const int opened = open(file.c_str(), flags, 0600);
  if (opened < 0 || dup2(opened, descriptor) < 0) _exit(127);
}

}  // namespace

Process::Process(const std::vector<std::string>& command, const fs::path& folder) : output_(make_folder()) {
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ > 0) return;
  redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
  redirect(STDOUT_FILENO, output_ / "out", O_WRONLY | O_CREAT);
  redirect(STDERR_FILENO, output_ / "err", O_WRONLY | O_CREAT);
  if (chdir(folder.c_str()) != 0) _exit(127);
  execv(arguments[0], arguments.data());
  _exit(127);
}

Process::~Process() {
  if (!ended_) {
    kill(pid_, SIGKILL);
    reap(0);
  }
  std::error_code ignored;
  fs::remove_all(output_, ignored);
}

void Process::reap(int options) {
  int status = 0;
  pid_t got = 0;
  do {
    got = waitpid(pid_, &status, options);
  } while (got < 0 && errno == EINTR);
  if (got != pid_) return;
  ended_ = true;
  status_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

bool Process::running() {
  if (!ended_) reap(WNOHANG);
  return !ended_;
}

bool Process::catches(int number) const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with("SigCgt:")) continue;
    return ((std::stoull(line.substr(7), nullptr, 16) >> (number - 1)) & 1) != 0;
  }
  return false;
}

void Process::signal(int number) const {
  if (!ended_) kill(pid_, number);
}

RunResult Process::wait() {
  if (!ended_) reap(0);
  return {status_, read_file(output_ / "out"), read_file(output_ / "err")};
}

RunResult run(const std::vector<std::string>& command, const fs::path& folder) {
  return Process(command, folder).wait();
}

ScratchFolder::ScratchFolder() : path_(make_folder()) {}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<std::string> ScratchFolder::names() const {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path ScratchFolder::write(const std::string& name, const std::string& bytes) const {
  std::ofstream out(path_ / name, std::ios::binary);
  out << bytes;
  if (!out.flush()) throw std::runtime_error(name + ": cannot write");
  return path_ / name;
}

std::string ScratchFolder::read(const std::string& name) const { return read_file(path_ / name); }

}  // namespace encage::test
