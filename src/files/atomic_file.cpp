// SPDX-License-Identifier: Apache-2.0
#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <string>
#include <system_error>

namespace encage {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const char* what, int error) {
  throw Error(file.string() + ": " + what + ": " + std::strerror(error));
}

void write_all(int descriptor, std::string_view bytes, const fs::path& file) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(file, "cannot write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// The descriptor of this process that `link` stands for (/proc/self/fd/1, /dev/fd/3), or -1.
int descriptor_of(const fs::path& link) {
  std::error_code none;
  const fs::path folder = fs::canonical(link.parent_path(), none);
  if (none || folder != "/proc/" + std::to_string(getpid()) + "/fd") return -1;
  const std::string name = link.filename();
  int number = -1;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc() && end == name.data() + name.size() ? number : -1;
}

/// Where links lead: to a name, or to something that this process has open, under whatever name.
struct Destination {
  fs::path path;
  int descriptor = -1;
};

Destination follow(const fs::path& file) {
  constexpr int most = 40;  // as on Linux
  Destination result{file};
  std::error_code none;
  for (int links = 0; fs::is_symlink(fs::symlink_status(result.path, none)); ++links) {
    if (links == most) fail(file, "cannot write", ELOOP);
    result.descriptor = descriptor_of(result.path);
    if (result.descriptor >= 0) break;
    // operator/ drops what is before an absolute target.
    result.path = result.path.parent_path() / fs::read_symlink(result.path, none);
    if (none) fail(file, "cannot write", none.value());
  }
  return result;
}

/// A descriptor that is closed at the end.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

void write_through(const fs::path& file, std::string_view bytes) {
  // What a descriptor has open goes on where it is; opened anew, a regular file would be written from its start.
  if (const int open_already = follow(file).descriptor; open_already >= 0) {
    if (open_already == STDOUT_FILENO) std::cout.flush();
    write_all(open_already, bytes, file);
    return;
  }
  const Descriptor opened(open(file.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY));
  if (opened.number() < 0) fail(file, "cannot write", errno);
  write_all(opened.number(), bytes, file);
}

/// A new file beside `target`; messages name `file`. The destructor removes the new file unless it has been renamed.
class Temporary {
 public:
  Temporary(const fs::path& target, const fs::path& file) : file_(file) {
    // Other processes that share the folder may have the same number, and a killed one may have left files behind.
    constexpr int attempts = 10000;
    static std::atomic<std::uint64_t> counter{0};
    for (int attempt = 0; descriptor_ < 0; ++attempt) {
      path_ = target.string() + "." + std::to_string(getpid()) + "-" + std::to_string(counter++);
      // O_EXCL never opens an existing file, not even through a link. The system applies the umask; a process with
      // several threads cannot read the umask without changing it.
      descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0 && (errno != EEXIST || attempt == attempts)) fail(file_, "cannot write", errno);
    }
  }
  ~Temporary() {
    if (descriptor_ >= 0) close(descriptor_);
    if (!renamed_) unlink(path_.c_str());
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  const std::string& path() const { return path_; }

  void write(std::string_view bytes) {
    write_all(descriptor_, bytes, file_);
    if (fsync(descriptor_) != 0 && errno != EINVAL) fail(file_, "cannot write", errno);
  }

  void replace(const fs::path& target) {
    if (std::rename(path_.c_str(), target.c_str()) != 0) fail(file_, "cannot replace", errno);
    renamed_ = true;
  }

 private:
  const fs::path& file_;
  std::string path_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

}  // namespace

bool is_written_through(const fs::path& file) {
  std::error_code none;
  const fs::file_type type = fs::status(file, none).type();
  if (type == fs::file_type::regular) return follow(file).descriptor >= 0;
  return type != fs::file_type::none && type != fs::file_type::not_found && type != fs::file_type::directory;
}

fs::path follow_links(const fs::path& file) { return follow(file).path; }

void write_atomically(const fs::path& file, std::string_view bytes,
                      const std::function<void(const fs::path&)>& inspect) {
  if (is_written_through(file)) {
    write_through(file, bytes);
    return;
  }
  const fs::path target = follow_links(file);
  Temporary temporary(target, file);
  temporary.write(bytes);
  if (inspect) inspect(temporary.path());
  temporary.replace(target);
}

}  // namespace encage
