// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_tree.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace encage {

/// Two parallel planes, in places of a grid: slab_unit * lower <= normal . place <= slab_unit * upper.
struct Slab {
  std::array<std::int8_t, 3> normal = {};
  std::int16_t lower = 0, upper = 0;

  /// normal . place of a vertex.
  static double height(const std::array<std::int8_t, 3>& normal, const Eigen::Vector3d& place) {
    return normal[0] * place.x() + normal[1] * place.y() + normal[2] * place.z();
  }
};

/// Finds thin slabs around triangles of a mesh.
class SlabFitter {
 public:
  /// `order`: triangle indices, kept by reference.
  SlabFitter(const TriangleMesh& mesh, const TreeGrid& grid, std::span<const std::int32_t> order);

  /// Around the triangles order[begin, end), begin < end: the thinnest whose normal is a principal axis of their
  /// corners or their mean normal. The same on every machine.
  Slab fit(std::int32_t begin, std::int32_t end) const;

 private:
  std::vector<std::array<Eigen::Vector3d, 3>> corners_;  // in places, in `order`
};

}  // namespace encage
