// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/asset.h>

#include <cstddef>
#include <filesystem>
#include <span>

namespace encage {

/// The bytes of a regular file in memory, read-only, at a page boundary. They stay valid until the object is destroyed
/// or assigned to. Not for use by several threads, but for reading bytes.
class FileImage {
 public:
  FileImage() = default;
  /// LoadMode::map maps the file, which must not be overwritten or truncated meanwhile (write_atomically() never does
  /// that). LoadMode::copy sets memory aside, zeros, and reads nothing yet. Throws Error naming the file and the
  /// reason.
  FileImage(const std::filesystem::path& file, LoadMode mode);
  ~FileImage();
  FileImage(FileImage&& other) noexcept;
  FileImage& operator=(FileImage&& other) noexcept;

  std::span<const std::byte> bytes() const { return bytes_; }
  LoadMode mode() const { return mode_; }

  /// Of a copy: reads a part of bytes() from the file, which is opened again if it was closed. Throws Error naming the
  /// file and the reason; the content of the part is then unspecified. Of a map: lets the system read it ahead. Memory
  /// outside bytes() is left alone, here and in discard().
  void fetch(std::span<const std::byte> part);
  /// Gives back the memory of the pages that lie wholly in a part of bytes(). In a copy they are zeros until they are
  /// fetched again; a map finds them in the file.
  void discard(std::span<const std::byte> part) noexcept;
  /// Closes the file of a copy; a map has none open.
  void close() noexcept;

 private:
  std::span<const std::byte> own(std::span<const std::byte> part) const;

  std::filesystem::path file_;
  LoadMode mode_ = LoadMode::map;
  int descriptor_ = -1;  // of a copy
  std::span<const std::byte> bytes_;
};

}  // namespace encage
