// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_tree.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace encage {

/// Two parallel planes, in grid coordinates x: slab_unit * lower <= normal . x <= slab_unit * upper.
struct Slab {
  std::array<std::int8_t, 3> normal = {};
  std::int16_t lower = 0, upper = 0;

  /// Returns normal . position of a vertex in grid coordinates.
  static double height(const std::array<std::int8_t, 3>& normal, const Eigen::Vector3d& position) {
    return normal[0] * position.x() + normal[1] * position.y() + normal[2] * position.z();
  }
};

/// Finds thin slabs around triangles of a mesh.
class SlabFitter {
 public:
  /// Keeps a reference to `order`, a list of triangle indices.
  SlabFitter(const TriangleMesh& mesh, const TreeGrid& grid, std::span<const std::int32_t> order);

  /// Fits a slab to the triangles order[begin, end), begin < end: the thinnest one whose normal is a principal axis of
  /// their corners or their mean normal. The result is the same on every machine.
  Slab fit(std::int32_t begin, std::int32_t end) const;

 private:
  std::vector<std::array<Eigen::Vector3d, 3>> corners_;  // in grid coordinates, sorted as `order`
};

}  // namespace encage
