// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <span>

namespace encage::makers {

using Point = Eigen::Vector3d;
using Corners = std::array<Point, 3>;

/// Conservative tests of the makers, in double. "True" is safe by a distance or an angle far above rounding; the
/// certificate decides exactly later.

/// True if some separating axis shows a gap wider than `clearance` between two triangles, degenerate ones included.
bool separated(const Corners& s, const Corners& t, double clearance);

/// Two triangles that share exactly their corner `apex`: true if they meet nowhere else.
bool separated_at_corner(const Point& apex, const Point& a, const Point& b, const Point& c, const Point& d);

/// Two triangles (a,b,c) and (b,a,d) around an edge: false if they nearly fold onto each other.
bool separated_at_edge(const Point& a, const Point& b, const Point& c, const Point& d);

/// Two triangles of one cage, with their vertex indices: true if they meet at most in the vertices or the edge they
/// share, and keep `clearance` if they share none.
bool separated(const std::array<std::int32_t, 3>& index_s, const Corners& s, const std::array<std::int32_t, 3>& index_t,
               const Corners& t, double clearance);

/// True if a direction is found that every unit normal faces: the vertex can be moved outward. Perceptron steps, which
/// end soon unless the cone is so thin that it may count as empty.
bool common_direction(std::span<const Point> normals);

/// Signed solid angle under which a triangle is seen from x; positive from its inner side.
double solid_angle(const Point& x, const Corners& t);

}  // namespace encage::makers
