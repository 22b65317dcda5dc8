// SPDX-License-Identifier: Apache-2.0
#include "src/mapped_file.h"

#include <encage/error.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace encage {

MappedFile::MappedFile(const std::filesystem::path& file) {
  // Non-blocking: opening a named pipe would wait for a writer.
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw Error(file.string() + ": cannot open: " + std::strerror(errno));
  const auto fail = [&](const std::string& reason) {
    close(descriptor);
    throw Error(file.string() + ": " + reason);
  };
  struct stat status {};
  if (fstat(descriptor, &status) != 0) fail(std::string("cannot read: ") + std::strerror(errno));
  if (!S_ISREG(status.st_mode)) fail("not a regular file");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > 0) {  // an empty range cannot be mapped
    void* const start = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (start == MAP_FAILED) fail(std::string("cannot map: ") + std::strerror(errno));
    bytes_ = {static_cast<const std::byte*>(start), size};
  }
  close(descriptor);
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

MappedFile::MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  return *this;
}

}  // namespace encage
