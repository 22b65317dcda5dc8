// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace encage {

/// A regular file mapped into memory, read-only. The bytes start at a page
/// boundary and stay valid until the object is destroyed or assigned to. The
/// file must not be truncated meanwhile (write_atomically never does that).
class MappedFile {
 public:
  MappedFile() = default;
  /// Throws Error naming the file and the reason.
  explicit MappedFile(const std::filesystem::path& file);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace encage
