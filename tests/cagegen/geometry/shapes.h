// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/separation.h"
#include "oracles/meshes.h"

// Triangles and boxes, random and awkward, for the tests of the makers.
namespace encage::makers::shapes {

using namespace encage::shapes;

inline Corners corners(const TriangleMesh& mesh, std::int64_t t) {
  return {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
}

inline TriangleMesh rounded(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

inline Point grid_point(Random& random, int n) {
  const int x = random.integer(n), y = random.integer(n), z = random.integer(n);
  return Point(x, y, z);
}

/// A triangle of size about `size`: fat, a sliver, on a coarse grid, or degenerate.
inline Corners awkward_triangle(Random& random, double size) {
  const Point a = random.point(1);
  const Point b = random.point(1);
  Corners t{a, b, random.point(1)};
  switch (random.integer(7)) {
    case 0: t[2] = a + random(0, 1) * (b - a) + random.point(1e-7); break;
    case 1: t[2] = a + 0.25 * (b - a); break;
    case 2: t[2] = b; break;
    case 3: t = {a, a, a}; break;
    case 4: t = {grid_point(random, 4), grid_point(random, 4), grid_point(random, 4)}; break;
    default: break;
  }
  for (Point& p : t) p *= size;
  return t;
}

}  // namespace encage::makers::shapes
