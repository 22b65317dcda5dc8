// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#include <utility>

namespace ENCAGE_EXPORT encage {

class Shape;
class OnDemandMesh;

/// Keeps the fine mesh of a shape of a ShapeCache in memory as long as the lease lives. Queries take leases of their
/// own; take one where a mesh must not be evicted between queries, or to read it before they start. For a compound,
/// take leases of its parts; a lease of a shape that belongs to no cache does nothing. The shape must outlive the
/// lease. A shape may have any number of leases, and a lease may be passed to another thread.
class FineLease {
 public:
  FineLease() = default;
  /// Throws Error, which names the file, if the mesh cannot be read or is damaged.
  explicit FineLease(const Shape& shape);
  ~FineLease() { release(); }
  FineLease(FineLease&& other) noexcept : mesh_(std::exchange(other.mesh_, nullptr)) {}
  FineLease& operator=(FineLease&& other) noexcept {
    std::swap(mesh_, other.mesh_);
    return *this;
  }

  /// Takes the mesh of `shape`. A lease that has a mesh already must have this one. Returns false where the constructor
  /// would throw.
  bool take(const Shape& shape) noexcept;

 private:
  void release() noexcept;

  OnDemandMesh* mesh_ = nullptr;
};

}  // namespace encage
