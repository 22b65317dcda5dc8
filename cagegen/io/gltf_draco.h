// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

namespace encage::io {

inline constexpr const char* draco_extension = "KHR_draco_mesh_compression";
/// Follows the extension's name.
inline constexpr const char* no_draco =
    "which this build of Encage cannot read; install Draco (Debian: libdraco-dev) and build Encage again, or "
    "decompress "
    "the file, for example with gltf-pipeline";

/// Returns true if this build has the library.
bool has_draco() noexcept;

/// Thrown for compressed data that are wrong; the message names neither file nor element.
struct DracoError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A primitive as Draco decodes it from its compressed bytes.
class DracoMesh {
 public:
  /// Throws DracoError if the bytes are damaged or the library is missing.
  explicit DracoMesh(std::span<const std::uint8_t> bytes);
  ~DracoMesh();
  DracoMesh(DracoMesh&& other) noexcept;
  DracoMesh& operator=(DracoMesh&& other) noexcept;

  std::int64_t vertex_count() const;
  /// Three for each triangle; each is below vertex_count().
  std::vector<std::int64_t> corners() const;
  /// `width` numbers for each vertex, of the attribute with this unique id; fractions if they are `normalized`
  /// integers. Throws DracoError if there is none, or it has another width.
  std::vector<double> attribute(std::int64_t id, int width, bool normalized) const;

 private:
  struct Decoded;
  std::unique_ptr<Decoded> decoded_;
};

}  // namespace encage::io
