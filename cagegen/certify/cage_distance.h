// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/certify/box_tree.h"

#include <encage/bake.h>

#include <array>
#include <cstdint>
#include <vector>

namespace encage::proof {

/// A surface that distances are measured to. Refers to the mesh.
class DistanceSurface {
 public:
  /// The mesh needs at least one triangle and valid indices.
  explicit DistanceSurface(const TriangleMesh& mesh);

  struct Foot {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< of the surface
    std::int32_t triangle = 0;                        ///< that holds it
    double distance = 0;                              ///< to `point`: never below that to the surface, but for rounding
  };

  /// The nearest point; any one of them, but always the same, where there are several. `start` is a triangle believed
  /// to be near.
  Foot nearest(const Eigen::Vector3d& p, std::int32_t start) const;
  /// A point of one triangle, the nearest but for rounding.
  Foot foot(const Eigen::Vector3d& p, std::int32_t triangle) const;

  /// The triangle on the other side of the edge from corner k to k + 1, which has to run along it in the opposite
  /// direction; -1 if there is none or more than one.
  std::int32_t neighbour(std::int32_t triangle, int k) const { return neighbour_[triangle][k]; }

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  const TriangleMesh& mesh_;
  BoxTree tree_;
  std::vector<std::array<std::int32_t, 3>> neighbour_;
};

/// distance_bounds(), for several cages around one surface.
DistanceBounds distance_bounds(const DistanceSurface& surface, const TriangleMesh& cage);

}  // namespace encage::proof
