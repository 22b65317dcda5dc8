// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace encage::proof {

// Exact predicates on points in double (CGAL's Exact_predicates_inexact_constructions_kernel, and rational numbers
// where a value is needed). No rounding takes part in an answer.

using Point = Eigen::Vector3d;
using Corners = std::array<Point, 3>;

inline Corners corners(const TriangleMesh& mesh, std::int32_t triangle) {
  return {mesh.corner(triangle, 0), mesh.corner(triangle, 1), mesh.corner(triangle, 2)};
}

/// The three points lie on a line (or coincide).
bool degenerate(const Corners& triangle);

/// The closed triangles have a point in common. `a` must not be degenerate; a degenerate `b` counts as the segment or
/// point that it is.
bool touch(const Corners& a, const Corners& b);

/// Non-degenerate triangles (v, a, b) and (v, c, d): do they have a point besides v in common?
bool overlap_at_vertex(const Point& v, const Point& a, const Point& b, const Point& c, const Point& d);

/// Non-degenerate triangles (v, w, a) and (v, w, b): do they have a point off the edge vw in common?
bool overlap_at_edge(const Point& v, const Point& w, const Point& a, const Point& b);

/// How the vertical line through `p`, shifted by an infinitesimal (e, e^2) in x and y, crosses the triangle above p: +1
/// upwards through it (leaving, if counter-clockwise from outside), -1 downwards, 0 not at all. The shift settles lines
/// through edges and vertices the same way for all triangles. `p` must not be a point of the triangle.
int crossing_above(const Corners& triangle, const Point& p);

/// Sign of the signed volume enclosed by the triangles `list` of a closed mesh.
int volume_sign(const TriangleMesh& mesh, const std::vector<std::int32_t>& list);

/// A lower bound, tight to a few units in the last place, of the distance between two triangles that do not touch;
/// degenerate ones are allowed. 0 if the distance is below the range of double. Rational arithmetic: slow.
double exact_distance(const Corners& a, const Corners& b);

}  // namespace encage::proof
