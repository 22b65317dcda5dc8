// SPDX-License-Identifier: Apache-2.0
#include "src/files/file_image.h"

#include <encage/error.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace encage {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  throw Error(file.string() + ": " + what + ": " + std::strerror(errno));
}

// The file is opened non-blocking, since opening a named pipe would otherwise wait for a writer.
int open_file(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) fail(file, "cannot open");
  return descriptor;
}

std::size_t size_of(int descriptor, const std::filesystem::path& file) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0) fail(file, "cannot read");
  if (!S_ISREG(status.st_mode)) throw Error(file.string() + ": not a regular file");
  return static_cast<std::size_t>(status.st_size);
}

std::uintptr_t page_size() { return static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE)); }

}  // namespace

FileImage::FileImage(const std::filesystem::path& file, LoadMode mode)
    : file_(file), mode_(mode), descriptor_(open_file(file)) {
  try {
    const std::size_t size = size_of(descriptor_, file);
    if (size > 0) {  // an empty range cannot be mapped
      void* const start = mode == LoadMode::map ? mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor_, 0)
                                                : mmap(nullptr, size, PROT_READ | PROT_WRITE,
                                                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
      if (start == MAP_FAILED) fail(file, "cannot map");
      bytes_ = {static_cast<const std::byte*>(start), size};
    }
  } catch (...) {
    close();
    throw;
  }
  if (mode == LoadMode::map) {
    close();
  } else {
    // The system does not read ahead, because only requested ranges are needed.
    posix_fadvise(descriptor_, 0, 0, POSIX_FADV_RANDOM);
  }
}

FileImage::~FileImage() {
  close();
  if (!bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

FileImage::FileImage(FileImage&& other) noexcept
    : file_(std::move(other.file_)),
      mode_(other.mode_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      bytes_(std::exchange(other.bytes_, {})) {}

FileImage& FileImage::operator=(FileImage&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(mode_, other.mode_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

/// Returns the intersection of `part` and bytes().
std::span<const std::byte> FileImage::own(std::span<const std::byte> part) const {
  const auto address = [](const std::byte* byte) { return reinterpret_cast<std::uintptr_t>(byte); };
  const std::uintptr_t start = std::max(address(part.data()), address(bytes_.data()));
  const std::uintptr_t end = std::min(address(part.data()) + part.size(), address(bytes_.data()) + bytes_.size());
  if (start >= end) return {};
  return bytes_.subspan(start - address(bytes_.data()), end - start);
}

void FileImage::fetch(std::span<const std::byte> part) {
  part = own(part);
  if (mode_ == LoadMode::map) {
    const auto start = reinterpret_cast<std::uintptr_t>(part.data()) / page_size() * page_size();
    const auto end = reinterpret_cast<std::uintptr_t>(part.data()) + part.size();
    // NOLINTNEXTLINE(performance-no-int-to-ptr): where a page starts
    if (start < end) madvise(reinterpret_cast<void*>(start), end - start, MADV_WILLNEED);
    return;
  }
  if (descriptor_ < 0) {
    descriptor_ = open_file(file_);
    size_of(descriptor_, file_);
  }
  while (!part.empty()) {
    const auto offset = static_cast<off_t>(part.data() - bytes_.data());
    const ssize_t count = pread(descriptor_, const_cast<std::byte*>(part.data()), part.size(), offset);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(file_, "cannot read");
    if (count == 0) {
      throw Error(file_.string() + ": cannot read: the file ends after " + std::to_string(size_of(descriptor_, file_)) +
                  " of its " + std::to_string(bytes_.size()) + " bytes");
    }
    part = part.subspan(static_cast<std::size_t>(count));
  }
}

void FileImage::discard(std::span<const std::byte> part) noexcept {
  part = own(part);
  const std::uintptr_t page = page_size();
  const auto start = (reinterpret_cast<std::uintptr_t>(part.data()) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(part.data()) + part.size()) / page * page;
  // NOLINTNEXTLINE(performance-no-int-to-ptr): where a page starts
  if (start < end) madvise(reinterpret_cast<void*>(start), end - start, MADV_DONTNEED);
}

void FileImage::close() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace encage
