// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Primitives and meshes in long double: brute force for pairs of them.

#include "oracles/body.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"

#include <encage/primitives.h>
#include <encage/shape_mesh.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {

constexpr double infinity = std::numeric_limits<double>::infinity();

inline Point real(const Eigen::Vector3d& p) { return p.cast<Real>(); }

/// A body as it was meant: all points within a radius of some triangles and of what these enclose.
struct TrueBody {
  std::string name;
  ShapePtr shape;
  std::vector<RealTriangle> triangles;  ///< in the body frame
  Real radius = 0;
  bool solid = false;    ///< the triangles enclose a volume
  bool unknown = false;  ///< what is inside is unknown
  double error = 0;      ///< how far the true body may be from this one, and the shape's mesh from the true body
  std::vector<std::size_t> parts = {0};  ///< a triangle of each connected part
};

/// The same in the world, at one time of a motion.
struct TruePlaced {
  std::vector<RealTriangle> triangles;
  Real radius;
  bool solid;
  std::vector<std::size_t> parts;
};

inline TruePlaced at(const TrueBody& body, const Motion& motion, Real t = 0) {
  TruePlaced placed{{}, Real(motion.scale) * body.radius, body.solid, body.parts};
  const auto moved = [&](const Point& x) -> Point {
    const Point s = Real(motion.scale) * x;
    const auto place = [&](const Eigen::Isometry3d& pose) -> Point {
      return pose.linear().cast<Real>() * s + pose.translation().cast<Real>();
    };
    return (1 - t) * place(motion.start) + t * place(motion.end);
  };
  for (const RealTriangle& x : body.triangles) placed.triangles.push_back({moved(x[0]), moved(x[1]), moved(x[2])});
  return placed;
}

/// How often the triangles surround a point, by solid angles (van Oosterom and Strackee 1983).
inline Real winding(const std::vector<RealTriangle>& triangles, const Point& p) {
  Real sum = 0;
  for (const RealTriangle& t : triangles) {
    const Point a = t[0] - p, b = t[1] - p, c = t[2] - p;
    const Real la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * std::acos(Real(-1)));
}

inline bool holds(const TruePlaced& body, const Point& p) {
  return body.solid && std::abs(winding(body.triangles, p)) > Real(0.5);
}

inline Real surface_distance_to(const std::vector<RealTriangle>& triangles, const Point& p) {
  Real least = std::numeric_limits<Real>::infinity();
  for (const RealTriangle& t : triangles) least = std::min(least, point_triangle_distance(p, t));
  return least;
}

/// The signed distance of a point from a convex body: negative inside.
inline Real signed_to(const TruePlaced& body, const Point& p) {
  const Real distance = surface_distance_to(body.triangles, p);
  return (holds(body, p) ? -distance : distance) - body.radius;
}

/// The distance of two bodies; where the bodies meet a number <= 0, which is less the deeper round bodies are.
inline Real gap(const TruePlaced& a, const TruePlaced& b) {
  Real least = std::numeric_limits<Real>::infinity();
  for (const RealTriangle& x : a.triangles) {
    for (const RealTriangle& y : b.triangles) {
      if (distance_bound(x, y) < least) least = std::min(least, triangle_distance(x, y));
    }
  }
  const auto held = [](const TruePlaced& host, const TruePlaced& guest) {
    return host.solid && std::any_of(guest.parts.begin(), guest.parts.end(),
                                     [&](std::size_t t) { return holds(host, guest.triangles[t][0]); });
  };
  if (least > 0 && (held(a, b) || held(b, a))) least = 0;
  return least - a.radius - b.radius;
}

inline std::vector<RealTriangle> triangles_of(const TriangleMesh& mesh, const Eigen::Vector3d& origin = {0, 0, 0}) {
  return at_time(mesh, origin, Motion{}, 0);
}

inline TrueBody true_box(const Eigen::Vector3d& half) {
  return {"box", make_box(half), triangles_of(shapes::box(-half, half)), 0, true, false, fine_error(*make_box(half))};
}

inline TrueBody true_capsule(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius) {
  const ShapePtr shape = make_capsule(a, b, radius);
  return {"capsule", shape, {{real(a), real(b), real(b)}}, radius, false, false, fine_error(*shape)};
}

inline TrueBody true_sphere(double radius) {
  const Point centre = Point::Zero();
  return {"sphere", make_sphere(radius), {{centre, centre, centre}}, radius, false, false, 0};
}

/// The triangles of the shape itself: what they are is another test's question.
inline std::vector<RealTriangle> core_triangles(const Shape& shape) {
  std::vector<RealTriangle> triangles;
  const ShapeMesh mesh = fine_mesh(shape);
  for (const auto& t : mesh.triangles) {
    triangles.push_back({real(mesh.vertex(t[0])), real(mesh.vertex(t[1])), real(mesh.vertex(t[2]))});
  }
  return triangles;
}

inline TrueBody true_hull(const std::vector<Eigen::Vector3d>& points, double radius) {
  const ShapePtr shape = make_convex_hull(points, radius);
  TrueBody body{"hull", shape, core_triangles(*shape), radius, false, false, fine_error(*shape)};
  body.solid = body.triangles.size() >= 4;
  return body;
}

/// The prism: the cylinder is within the error.
inline TrueBody true_cylinder(double half_height, double radius, int sides) {
  const ShapePtr shape = make_cylinder(half_height, radius, sides);
  return {"cylinder", shape, core_triangles(*shape), 0, true, false, fine_error(*shape)};
}

/// Primitives of every kind, up to 2 wide.
inline std::vector<TrueBody> primitives() {
  std::vector<TrueBody> all = {true_sphere(0.7),
                               true_sphere(0.1),
                               true_capsule({0, -0.5, 0}, {0, 0.5, 0}, 0.3),
                               true_capsule({-0.4, 0.1, 0.3}, {0.5, 0.7, -0.2}, 0.05),
                               true_box({0.5, 0.375, 0.25}),
                               true_box({0.7, 0.1, 0.013}),
                               true_cylinder(0.5, 0.4, 8)};
  shapes::Random random(3);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 12; ++i) points.push_back(random.point(0.7));
  all.push_back(true_hull(points, 0));
  all.push_back(true_hull(points, 0.2));
  all.push_back(true_hull({{0, 0, 0}, {0.8, 0, 0.1}, {0, 0.6, 0}, {0.9, 0.7, 0.1125}}, 0.15));
  all.back().name = "plate";
  return all;
}

/// Small meshes of every kind.
inline std::vector<TrueBody> true_meshes() {
  std::vector<TrueBody> all;
  std::vector<Body> bodies = sample_bodies();
  bodies.emplace_back(bodies[1].sample, 1, true);
  for (const Body& body : bodies) {
    if (!body.has_fine() || body.mesh().triangles.rows() > 64) continue;
    all.push_back({body.sample.name, body.shape, triangles_of(body.mesh(), body.origin()), 0,
                   body.solid() && is_closed(body.mesh()), !body.hollow && !(body.solid() && is_closed(body.mesh())),
                   fine_error(*body.shape)});
    std::vector<std::int32_t> label;
    std::vector<std::size_t>& parts = all.back().parts;
    parts.resize(static_cast<std::size_t>(triangle_components(body.mesh(), label)));
    for (std::size_t t = 0; t < label.size(); ++t) parts[static_cast<std::size_t>(label[t])] = t;
  }
  return all;
}

/// Rigid to the last bit or so, as queries want.
inline Eigen::Isometry3d rigid_pose(shapes::Random& random, double reach) {
  Eigen::Isometry3d pose = random_pose(random, reach);
  pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return pose;
}

}  // namespace encage::test
