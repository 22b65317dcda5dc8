// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/nearest_point.h"
#include "broadphase/primitives/convex_hull.h"
#include "broadphase/separation/containment.h"
#include "broadphase/shape/shape.h"
#include "src/files/number_text.h"
#include "src/limits.h"
#include "src/mesh/portable_trig.h"
#include "src/mesh/rounding.h"

#include <encage/error.h>
#include <encage/primitives.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace encage {
namespace {

using std::numbers::pi;

void require_size(const char* primitive, const std::string& argument, double value) {
  if (value >= smallest_extent && value <= largest_coordinate) return;
  throw Error(std::string(primitive) + ": " + argument + " is " + number_text(value) +
              ", and has to be between 1e-30 and 1e37");
}

void require_point(const char* primitive, const std::string& argument, const Eigen::Vector3d& point) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(point[k]) <= largest_coordinate) continue;
    throw Error(std::string(primitive) + ": " + argument + "[" + std::to_string(k) + "] is " + number_text(point[k]) +
                ", and has to be finite and at most 1e37");
  }
}

TriangleMesh primitive_mesh(const std::vector<Eigen::Vector3d>& vertices, Triangles triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v].transpose();
  }
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// The moments of a body of this volume about its centre, from the principal moments of inertia along the columns of
/// `axes`.
SimpleShape::KnownMoments moments_about(const SimpleShape& shape, const Eigen::Vector3d& centre, double volume,
                                        const Eigen::Matrix3d& axes, const Eigen::Vector3d& inertia) {
  SimpleShape::KnownMoments known;
  known.apex = centre - shape.frame.origin;
  known.moments.volume = volume;
  // Integrals of x^2, y^2 and z^2: the tensor of inertia has their sums.
  const Eigen::Vector3d squares = Eigen::Vector3d::Constant(0.5 * inertia.sum()) - inertia;
  known.moments.second = axes * squares.asDiagonal() * axes.transpose();
  return known;
}

/// A rotation whose second column is along `way`; any if that is 0.
Eigen::Matrix3d frame_along(const Eigen::Vector3d& way) {
  const Eigen::Vector3d y = way.isZero(0) ? Eigen::Vector3d::UnitY() : Eigen::Vector3d(way.stableNormalized());
  Eigen::Matrix3d axes;
  axes.col(1) = y;
  axes.col(0) = y.unitOrthogonal();
  axes.col(2) = axes.col(0).cross(y);
  return axes;
}

/// The ball or the capsule about the segment.
std::shared_ptr<SimpleShape> rounded_segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius) {
  Triangles triangle(1, 3);
  std::vector<Eigen::Vector3d> ends = {a};
  if (a == b) {
    triangle << 0, 0, 0;
  } else {
    ends.push_back(b);
    triangle << 0, 1, 1;
  }
  auto shape = make_primitive(primitive_mesh(ends, triangle), 0, radius, true);
  const double length = (b - a).norm(), squared = radius * radius;
  const double tube = pi * squared * length, ball = 4 * pi / 3 * squared * radius;
  const double around = tube * squared / 2 + ball * 2 * squared / 5;
  const double across = tube * (length * length / 12 + squared / 4) +
                        ball * (2 * squared / 5 + length * length / 4 + 3 * length * radius / 8);
  shape->known_moments =
      moments_about(*shape, 0.5 * a + 0.5 * b, tube + ball, frame_along(b - a), {across, around, across});
  return shape;
}

Triangles box_triangles() {
  Triangles t(12, 3);
  t << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5;
  return t;
}

/// A prism's vertex 2 i is at y = -h, 2 i + 1 at y = h above it.
Triangles prism_triangles(int sides) {
  Triangles t(4 * sides - 4, 3);
  Eigen::Index row = 0;
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    t.row(row++) << 2 * i, 2 * j + 1, 2 * i + 1;
    t.row(row++) << 2 * i, 2 * j, 2 * j + 1;
  }
  // Zigzag from side to side: a fan's triangles would be thinner.
  int low = 0, high = sides - 1;
  for (bool next_low = true; high - low > 1; next_low = !next_low) {
    const int from = low, to = high, middle = next_low ? ++low : --high;
    t.row(row++) << 2 * from, 2 * to, 2 * middle;
    t.row(row++) << 2 * from + 1, 2 * middle + 1, 2 * to + 1;
  }
  return t;
}

/// Bounds, in the local frame, how far points that the hull should hold are outside of the fine mesh.
double left_outside(const SimpleShape& shape, std::span<const Eigen::Vector3d> points) {
  double most = 0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = point - shape.frame.origin;
    SurfacePoint nearest;
    if (!shape.hollow && locate(shape.fine, p) == Side::inside) continue;
    if (nearest_point(shape.fine, p, infinity, nearest)) most = std::max(most, nearest.distance);
  }
  // Rounding may make edges concave by some units of the size, too.
  return most * (1 + 1e-9) + (shape.fine_vertices > 2 ? 64 * eps * shape.frame.reach() : 0);
}

}  // namespace

ShapePtr make_sphere(double radius) {
  require_size("sphere", "the radius", radius);
  return rounded_segment(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), radius);
}

ShapePtr make_capsule(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius) {
  require_point("capsule", "a", a);
  require_point("capsule", "b", b);
  require_size("capsule", "the radius", radius);
  return rounded_segment(a, b, radius);
}

ShapePtr make_capsule(double half_length, double radius) {
  if (!(half_length >= 0 && half_length <= largest_coordinate)) {
    throw Error("capsule: the half length is " + number_text(half_length) + ", and has to be between 0 and 1e37");
  }
  return make_capsule({0, -half_length, 0}, {0, half_length, 0}, radius);
}

ShapePtr make_box(const Eigen::Vector3d& half) {
  for (int k = 0; k < 3; ++k) require_size("box", "half[" + std::to_string(k) + "]", half[k]);
  std::vector<Eigen::Vector3d> corners;
  for (unsigned i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    corners.emplace_back(sign.cwiseProduct(half));
  }
  auto shape = make_primitive(primitive_mesh(corners, box_triangles()), 0, 0, false);
  const double volume = 8 * half.prod();
  const Eigen::Vector3d squares = half.cwiseAbs2() * (volume / 3);
  shape->known_moments = moments_about(*shape, Eigen::Vector3d::Zero(), volume, Eigen::Matrix3d::Identity(),
                                       Eigen::Vector3d::Constant(squares.sum()) - squares);
  return shape;
}

ShapePtr make_cylinder(double half_height, double radius, int sides) {
  require_size("cylinder", "the half height", half_height);
  require_size("cylinder", "the radius", radius);
  if (sides < 3 || sides > 4096) {
    throw Error("cylinder: the number of sides is " + std::to_string(sides) + ", and has to be between 3 and 4096");
  }
  // Corners at c beyond the circle are as far from it as the middles of sides, at c cos(pi / sides), are within it.
  const double cosine = sincos_turns(0.5 / sides).cos, corner = 2 * radius / (1 + cosine);
  std::vector<Eigen::Vector3d> vertices;
  for (int i = 0; i < sides; ++i) {
    const SinCos at = sincos_turns(static_cast<double>(i) / sides);
    vertices.emplace_back(corner * at.sin, -half_height, corner * at.cos);
    vertices.emplace_back(corner * at.sin, half_height, corner * at.cos);
  }
  // Sines and cosines are off by 1e-12.
  const double error = std::max(corner - radius, radius - corner * cosine) + 8e-12 * radius;
  auto shape = make_primitive(primitive_mesh(vertices, prism_triangles(sides)), error, 0, false);
  const double squared = radius * radius, volume = 2 * pi * squared * half_height;
  const double across = volume * (squared / 4 + half_height * half_height / 3);
  shape->known_moments = moments_about(*shape, Eigen::Vector3d::Zero(), volume, Eigen::Matrix3d::Identity(),
                                       {across, volume * squared / 2, across});
  return shape;
}

ShapePtr make_convex_hull(std::span<const Eigen::Vector3d> points, double radius) {
  if (points.empty()) throw Error("convex hull: there are no points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    require_point("convex hull", "points[" + std::to_string(i) + "]", points[i]);
  }
  if (radius != 0) require_size("convex hull", "the radius", radius);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  if (radius == 0 && !(box.diagonal().norm() >= smallest_extent)) {
    throw Error("convex hull: the points extend over " + number_text(box.diagonal().norm()) +
                ", and have to over 1e-30 or more, if the radius is 0");
  }
  const Eigen::Vector3d origin = local_origin(box);
  std::vector<Eigen::Vector3d> rounded;
  for (const Eigen::Vector3d& p : points) rounded.push_back(round_to_float(p - origin));
  HullMesh hull = convex_hull(rounded, 1e-6);
  if (hull.flat && radius == 0) {
    throw Error("convex hull: the " + std::to_string(points.size()) +
                " points lie in a plane, within 1e-6 of their extent: a radius > 0 would make them a solid");
  }
  std::shared_ptr<SimpleShape> shape;
  if (hull.points.size() <= 2) {
    shape = rounded_segment(points[hull.points.front()], points[hull.points.back()], radius);
  } else {
    std::vector<Eigen::Vector3d> vertices;
    for (const std::int32_t i : hull.points) vertices.push_back(points[i]);
    shape = make_primitive(primitive_mesh(vertices, std::move(hull.triangles)), 0, radius, hull.flat);
  }
  shape->fine_error += left_outside(*shape, points);
  return shape;
}

}  // namespace encage
