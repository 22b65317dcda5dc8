// SPDX-License-Identifier: Apache-2.0
#include "src/files/read_file.h"

#include <encage/error.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

namespace encage {
namespace {

std::string read_to_end(int descriptor, const std::filesystem::path& file) {
  std::string bytes;
  std::size_t size = 0;
  struct stat status {};
  std::size_t step = 1 << 16;
  if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) {
    // One byte more than the file has, in order to see its end.
    step = std::max(step, static_cast<std::size_t>(status.st_size) + 1);
  }
  for (;;) {
    if (size == bytes.size()) bytes.resize(size + std::max(step, size));
    const ssize_t count = read(descriptor, bytes.data() + size, bytes.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw Error(file.string() + ": cannot read: " + std::strerror(errno));
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::string read_file(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw Error(file.string() + ": cannot open: " + std::strerror(errno));
  try {
    std::string bytes = read_to_end(descriptor, file);
    close(descriptor);
    return bytes;
  } catch (...) {
    close(descriptor);
    throw;
  }
}

std::string read_standard_input(const std::filesystem::path& name) { return read_to_end(STDIN_FILENO, name); }

}  // namespace encage
