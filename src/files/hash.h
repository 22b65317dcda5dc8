// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/cage.h>
#include <encage/mesh.h>

#include <cstddef>
#include <memory>
#include <span>

namespace encage {

/// Returns the XXH3-128 hash of the bytes (seed 0, default secret).
Hash hash_bytes(std::span<const std::byte> bytes);

/// Computes the XXH3-128 hash of a sequence of byte ranges: the hash of their concatenation.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(Hasher&&) noexcept;
  Hasher& operator=(Hasher&&) noexcept;

  void add(std::span<const std::byte> bytes);
  /// Returns the hash of everything added so far. More ranges may be added afterwards.
  Hash digest() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the hash of vertices and triangles as they are: CageHierarchy::source_hash of a source.
Hash hash_mesh(const TriangleMesh& mesh);

}  // namespace encage
