// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <vector>

namespace encage::zoo {

// What the baselines are made of, as far as it needs CGAL.

/// Progressive hull of a closed manifold; more than `faces` triangles if it gets stuck. Every vertex lies `lift`
/// outside of the planes that were around it, if it can.
TriangleMesh collapse_outward(const TriangleMesh& mesh, std::int64_t faces, double lift);

/// Distance from a mesh on a grid: signed if the mesh is closed (negative inside), else unsigned.
class DistanceGrid {
 public:
  /// `cells` along the longest side of the bounds, grown by `reach` on each side.
  DistanceGrid(const TriangleMesh& mesh, bool closed, int cells, double reach);

  /// The outermost surfaces at this distance, at most `reach`: a closed manifold, by marching tetrahedra.
  TriangleMesh contour(double distance) const;
  double cell() const { return cell_; }

 private:
  struct GridNode {
    int x, y, z;
  };
  std::int64_t index(const GridNode& n) const { return (std::int64_t{n.z} * count_[1] + n.y) * count_[0] + n.x; }
  Eigen::Vector3d position(const GridNode& n) const { return low_ + cell_ * Eigen::Vector3d(n.x, n.y, n.z); }

  Eigen::Vector3d low_;
  double cell_ = 0;
  int count_[3] = {0, 0, 0};  ///< nodes
  std::vector<double> values_;
};

}  // namespace encage::zoo
