// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#include <utility>

namespace ENCAGE_EXPORT encage {

class Shape;
class OnDemandMesh;

/// Keeps the fine mesh of a shape of a ShapeCache in memory while it lives. Queries take their own; hold one where a
/// mesh must not be evicted between queries, or to have it read ahead of them. Of a compound, take its parts; for other
/// shapes there is nothing to do.
/// The shape must outlive it. A lease may be passed to another thread; any number of leases per shape.
class FineLease {
 public:
  FineLease() = default;
  /// Throws Error, naming the file, if the mesh can not be read or is damaged.
  explicit FineLease(const Shape& shape);
  ~FineLease() { release(); }
  FineLease(FineLease&& other) noexcept : mesh_(std::exchange(other.mesh_, nullptr)) {}
  FineLease& operator=(FineLease&& other) noexcept {
    std::swap(mesh_, other.mesh_);
    return *this;
  }

  /// Takes the mesh of `shape`, unless this has one: then it must be the same. False in place of an Error.
  bool take(const Shape& shape) noexcept;

 private:
  void release() noexcept;

  OnDemandMesh* mesh_ = nullptr;
};

}  // namespace encage
