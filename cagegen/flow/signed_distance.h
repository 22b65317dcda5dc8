// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/flow/point_triangle.h"
#include "cagegen/flow/winding.h"
#include "cagegen/geometry/triangle_tree.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace encage::makers {

/// What decides on which side of a mesh a point lies.
enum class Sign {
  pseudonormal,  ///< the angle-weighted normal at the closest point; for closed embedded meshes
  winding,       ///< winding number above 1/2: for soups, open and self-intersecting meshes; slower
};

/// What a mesh is to a point.
struct Nearest {
  Point point = Point::Zero();      ///< closest point of the mesh
  Point direction = Point::Zero();  ///< unit gradient of the signed distance: g of Nested Cages, eq. 6
  double distance = 0;              ///< signed: negative inside
  std::int32_t triangle = -1;       ///< that holds the closest point; of several the first
  Feature feature = Feature::face;  ///< of that triangle
};

/// Signed distance to a mesh, exact but for rounding in double. Queries are re-entrant.
class SignedDistance {
 public:
  /// The mesh is copied; it must have a triangle. Throws Error if not.
  explicit SignedDistance(const TriangleMesh& mesh, Sign sign = Sign::pseudonormal);

  /// `start` is a triangle believed to be near, best the closest one of a point close by; the answer does not depend on
  /// it, only the time.
  Nearest nearest(const Point& p, std::int32_t start = 0) const;

  /// Nearer than this the direction is the normal at the closest point, epsilon of eq. 6: 1e-5 diagonals.
  double epsilon() const { return epsilon_; }

 private:
  struct Triangle {
    Corners corner;
    std::int32_t index = 0;  ///< in the mesh
    bool thin = false;
  };
  void compute_normals(const TriangleMesh& mesh);
  Point normal(std::int32_t triangle, Feature feature) const;

  Triangles corners_;                              ///< vertex indices
  std::vector<Triangle> triangles_;                ///< in the order of the tree's leaves
  std::vector<std::int32_t> slot_;                 ///< of each triangle of the mesh in triangles_
  std::vector<Point> face_normal_;                 ///< unit, per triangle of the mesh
  std::vector<std::array<Point, 3>> edge_normal_;  ///< sum of the faces' at the edge corner k -> k + 1
  std::vector<Point> vertex_normal_;               ///< weighted by the angles
  TriangleTree tree_;
  std::optional<WindingNumber> winding_;
  double epsilon_ = 0;
};

}  // namespace encage::makers
