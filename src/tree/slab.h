// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_tree.h"

#include <encage/mesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
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

/// Bounds of points along up to four directions, of which the thinnest gives a slab. Points are in grid coordinates.
class SlabBounds {
 public:
  void add_normal(const std::array<std::int8_t, 3>& normal) {
    normals_[count_] = normal;
    for (std::size_t axis = 0; axis < 3; ++axis) direction_[count_][axis] = normal[axis];
    ++count_;
  }
  void add_normal(const Eigen::Vector3d& direction);  ///< rounded

  /// Adds the points point(0), …, point(count - 1).
  template <class Point>
  void add(std::int32_t count, const Point& point) {
    for (std::size_t k = 0; k < count_; ++k) {
      const double x = direction_[k][0], y = direction_[k][1], z = direction_[k][2];
      double low = low_[k], high = high_[k];
      for (std::int32_t i = 0; i < count; ++i) {
        const Eigen::Vector3d& p = point(i);
        const double height = x * p.x() + y * p.y() + z * p.z();
        low = std::min(low, height);
        high = std::max(high, height);
      }
      low_[k] = low;
      high_[k] = high;
    }
  }
  void add_box(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper);

  /// Requires points.
  Slab thinnest() const;

 private:
  static constexpr std::size_t most = 4;
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  std::size_t count_ = 0;
  std::array<std::array<std::int8_t, 3>, most> normals_{};
  std::array<std::array<double, 3>, most> direction_{};
  std::array<double, most> low_ = {infinity, infinity, infinity, infinity};
  std::array<double, most> high_ = {-infinity, -infinity, -infinity, -infinity};
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
