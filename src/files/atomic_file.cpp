// SPDX-License-Identifier: Apache-2.0
#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

namespace encage {
namespace {

/// A new file beside another one. Its destructor removes it unless it has been renamed.
class Temporary {
 public:
  explicit Temporary(const std::filesystem::path& file) : file_(file) {
    // Other processes that share the folder may have the same number, and a killed one may have left files behind.
    constexpr int attempts = 10000;
    static std::atomic<std::uint64_t> counter{0};
    for (int attempt = 0; descriptor_ < 0; ++attempt) {
      path_ = file.string() + "." + std::to_string(getpid()) + "-" + std::to_string(counter++);
      // O_EXCL never opens an existing file, not even through a link. The system applies the umask; a process with
      // several threads cannot read the umask without changing it.
      descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0 && (errno != EEXIST || attempt == attempts)) fail("cannot write");
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
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail("cannot write");
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    if (fsync(descriptor_) != 0 && errno != EINVAL) fail("cannot write");
  }

  void replace_file() {
    if (std::rename(path_.c_str(), file_.c_str()) != 0) fail("cannot replace");
    renamed_ = true;
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    throw Error(file_.string() + ": " + what + ": " + std::strerror(errno));
  }

  const std::filesystem::path& file_;
  std::string path_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

}  // namespace

void write_atomically(const std::filesystem::path& file, std::string_view bytes,
                      const std::function<void(const std::filesystem::path&)>& inspect) {
  Temporary temporary(file);
  temporary.write(bytes);
  if (inspect) inspect(temporary.path());
  temporary.replace_file();
}

}  // namespace encage
