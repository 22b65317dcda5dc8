// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/asset.h>

#include <cstddef>
#include <filesystem>
#include <span>

namespace encage {

/// The bytes of a regular file in memory, read-only, at a page boundary. They stay valid until the object is destroyed
/// or assigned to. Several threads may read the bytes at a time; the functions are for one thread.
class FileImage {
 public:
  FileImage() = default;
  /// LoadMode::map maps the file, which must not be overwritten or truncated meanwhile (write_atomically() never does
  /// that). LoadMode::copy reserves zeroed memory and reads nothing yet. Throws Error naming the file and the reason.
  FileImage(const std::filesystem::path& file, LoadMode mode);
  ~FileImage();
  FileImage(FileImage&& other) noexcept;
  FileImage& operator=(FileImage&& other) noexcept;

  std::span<const std::byte> bytes() const { return bytes_; }
  LoadMode mode() const { return mode_; }

  /// For a copy, reads a part of bytes() from the file, and opens the file again if it was closed. Throws Error naming
  /// the file and the reason; the content of the part is then unspecified. For a map, lets the system read the part
  /// ahead. Neither this nor discard() touches memory outside bytes().
  void fetch(std::span<const std::byte> part);
  /// Frees the memory of the pages that lie entirely in a part of bytes(). In a copy they then contain zeros until they
  /// are fetched again; a map reads them from the file again.
  void discard(std::span<const std::byte> part) noexcept;
  /// Closes the file of a copy; a map keeps no file open.
  void close() noexcept;

 private:
  std::span<const std::byte> own(std::span<const std::byte> part) const;

  std::filesystem::path file_;
  LoadMode mode_ = LoadMode::map;
  int descriptor_ = -1;  // used by copies only
  std::span<const std::byte> bytes_;
};

}  // namespace encage
