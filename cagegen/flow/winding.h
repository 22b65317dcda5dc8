// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/separation.h"

#include <encage/mesh.h>

#include <span>
#include <vector>

namespace encage::makers {

/// Generalised winding number of a triangle soup: 1 inside, 0 outside a closed surface, between and beyond for open and
/// self-intersecting ones (Jacobson et al. 2013), by a tree whose far nodes count as dipoles (Barill et al. 2018). It
/// guides makers; it proves nothing. Queries are re-entrant.
class WindingNumber {
 public:
  explicit WindingNumber(const TriangleMesh& mesh);

  double operator()(const Point& p) const;

 private:
  struct Node {
    Point centre = Point::Zero();  ///< of the area
    Point dipole = Point::Zero();  ///< sum of the area vectors
    double reach2 = 0;             ///< square of the distance from which the node counts as a dipole
    std::int32_t first = 0;        ///< triangles [first, last)
    std::int32_t last = 0;
    std::int32_t right = 0;  ///< second child, the first one follows; 0: a leaf
  };
  std::int32_t build(std::span<Corners> triangles, std::int32_t first);

  std::vector<Corners> triangles_;
  std::vector<Node> nodes_;
};

/// Solid angle of one triangle over the full one; the sum over a mesh is the winding number.
double winding_of_triangle(const Point& p, const Corners& t);

}  // namespace encage::makers
