// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/obstacle.h"
#include "cagegen/geometry/triangle_tree.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace encage::makers {

using TrianglePair = std::array<std::int32_t, 2>;

inline std::array<std::int32_t, 3> indices(const TriangleMesh& mesh, std::int64_t t) {
  return {mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
}

inline Corners corners(const TriangleMesh& mesh, std::int64_t t) {
  return {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
}

/// The triangles of one mesh in a tree. Their vertices may move, within a box somewhat larger than the mesh was; after
/// that the tree must be told. Refers to the mesh.
class SurfaceTree {
 public:
  explicit SurfaceTree(const TriangleMesh& mesh);

  void update(std::int32_t triangle);
  void remove(std::int32_t triangle) { tree_.remove(triangle); }
  /// Tight boxes again, of all triangles but those whose first corner index is negative.
  void rebuild();

  /// Calls visit(t) for each triangle whose box may come within `gap` of the prism's triangle.
  template <class Visit>
  void near(const Prism& prism, double gap, const Visit& visit) const {
    tree_.traverse(filter(prism, gap), visit);
  }
  /// The same for a ray.
  template <class Visit>
  void along(const Point& start, const Point& direction, const Visit& visit) const {
    tree_.traverse(ray_filter(start, direction), visit);
  }

 private:
  BoxFilter filter(const Prism& prism, double gap) const;
  BoxFilter ray_filter(const Point& start, const Point& direction) const;

  const TriangleMesh& mesh_;
  Eigen::AlignedBox3d room_;
  TriangleTree tree_;
};

/// All pairs of triangles in contact, in a fixed order: they come nearer to each other than `gap` without sharing a
/// vertex, or fold onto each other where they share one. A degenerate triangle is in contact with itself.
std::vector<TrianglePair> self_contacts(const TriangleMesh& mesh, double gap);

}  // namespace encage::makers
