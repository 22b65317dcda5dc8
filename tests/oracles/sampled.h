// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Distances of triangles in long double, and bodies at sampled times: brute force for moving bodies. Every distance is
// one between two points of the triangles, hence never below the true one except by rounding.

#include "oracles/meshes.h"

#include <encage/shape.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace encage::test {

using Real = long double;
using Point = Eigen::Matrix<Real, 3, 1>;
using RealTriangle = std::array<Point, 3>;

inline Real point_segment_distance(const Point& p, const Point& a, const Point& b) {
  const Point u = b - a;
  const Real squared = u.squaredNorm();
  const Real t = squared > 0 ? std::clamp<Real>(u.dot(p - a) / squared, 0, 1) : 0;
  return (a + t * u - p).norm();
}

inline Real point_triangle_distance(const Point& p, const RealTriangle& t) {
  const Point n = (t[1] - t[0]).cross(t[2] - t[0]);
  bool above = n.squaredNorm() > 0;
  for (int k = 0; k < 3 && above; ++k) {
    above = n.cross(t[(k + 1) % 3] - t[k]).dot(p - t[k]) >= 0;
  }
  if (above) return std::abs(n.normalized().dot(p - t[0]));
  return std::min({point_segment_distance(p, t[0], t[1]), point_segment_distance(p, t[1], t[2]),
                   point_segment_distance(p, t[2], t[0])});
}

/// The distance of the lines if it is attained between points of the segments; otherwise the ends decide.
inline Real edge_edge_distance(const Point& p0, const Point& p1, const Point& q0, const Point& q1) {
  const Point u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const Real uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const Real determinant = uu * vv - uv * uv;
  if (determinant > 0) {
    const Real s = (uv * vw - vv * uw) / determinant, t = (uu * vw - uv * uw) / determinant;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return (w + s * u - t * v).norm();
  }
  return std::min({point_segment_distance(p0, q0, q1), point_segment_distance(p1, q0, q1),
                   point_segment_distance(q0, p0, p1), point_segment_distance(q1, p0, p1)});
}

/// True if the segment crosses the triangle.
inline bool pierces(const Point& a, const Point& b, const RealTriangle& t) {
  const Point n = (t[1] - t[0]).cross(t[2] - t[0]);
  const Real da = n.dot(a - t[0]), db = n.dot(b - t[0]);
  if ((da > 0) == (db > 0)) return false;
  const Point x = a + (da / (da - db)) * (b - a);
  for (int k = 0; k < 3; ++k) {
    if (!(n.cross(t[(k + 1) % 3] - t[k]).dot(x - t[k]) >= 0)) return false;
  }
  return true;
}

inline Real triangle_distance(const RealTriangle& a, const RealTriangle& b) {
  Real least = std::numeric_limits<Real>::infinity();
  for (int i = 0; i < 3; ++i) {
    if (pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a)) return 0;
    least = std::min({least, point_triangle_distance(a[i], b), point_triangle_distance(b[i], a)});
    for (int j = 0; j < 3; ++j) {
      least = std::min(least, edge_edge_distance(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
    }
  }
  return least;
}

/// A lower bound of the distance.
inline Real distance_bound(const RealTriangle& a, const RealTriangle& b) {
  Real squared = 0;
  for (int k = 0; k < 3; ++k) {
    const Real low_a = std::min({a[0][k], a[1][k], a[2][k]}), high_a = std::max({a[0][k], a[1][k], a[2][k]});
    const Real low_b = std::min({b[0][k], b[1][k], b[2][k]}), high_b = std::max({b[0][k], b[1][k], b[2][k]});
    const Real gap = std::max({low_b - high_a, low_a - high_b, Real(0)});
    squared += gap * gap;
  }
  return std::sqrt(squared);
}

/// Returns the triangles of a mesh (local frame, about `origin`) in the world, every vertex on the line between its two
/// positions.
inline std::vector<RealTriangle> at_time(const TriangleMesh& mesh, const Eigen::Vector3d& origin, const Motion& motion,
                                         Real t) {
  const auto place = [&](const Eigen::Isometry3d& pose, const Point& x) -> Point {
    return pose.linear().cast<Real>() * x + pose.translation().cast<Real>();
  };
  std::vector<Point> vertices;
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    const Point x = Real(motion.scale) * (origin.cast<Real>() + mesh.vertices.row(v).transpose().cast<Real>());
    vertices.push_back((1 - t) * place(motion.start, x) + t * place(motion.end, x));
  }
  std::vector<RealTriangle> triangles;
  for (std::int64_t i = 0; i < mesh.triangles.rows(); ++i) {
    triangles.push_back(
        {vertices[mesh.triangles(i, 0)], vertices[mesh.triangles(i, 1)], vertices[mesh.triangles(i, 2)]});
  }
  return triangles;
}

/// Returns the least distance of each pair of triangles (index: a's times the number of b's, plus b's) over `samples` +
/// 1 times of the step from 0 to `last`; any larger value if it exceeds `limit`.
inline std::vector<Real> least_distances(const TriangleMesh& a, const Eigen::Vector3d& origin_a, const Motion& motion_a,
                                         const TriangleMesh& b, const Eigen::Vector3d& origin_b, const Motion& motion_b,
                                         Real limit, int samples, Real last = 1) {
  std::vector<Real> least(static_cast<std::size_t>(a.triangles.rows() * b.triangles.rows()),
                          std::numeric_limits<Real>::infinity());
  for (int s = 0; s <= samples; ++s) {
    const Real t = last * s / samples;
    const auto ta = at_time(a, origin_a, motion_a, t), tb = at_time(b, origin_b, motion_b, t);
    for (std::size_t i = 0; i < ta.size(); ++i) {
      for (std::size_t j = 0; j < tb.size(); ++j) {
        Real& value = least[i * tb.size() + j];
        if (distance_bound(ta[i], tb[j]) > std::min(value, limit)) continue;
        value = std::min(value, triangle_distance(ta[i], tb[j]));
      }
    }
  }
  return least;
}

/// Least value of a function of time near its least sample, by narrower and narrower intervals around it.
template <class Function>
Real least_value(Function&& value, Real from = 0, Real to = 1) {
  constexpr int count = 24;
  Real best = std::numeric_limits<Real>::infinity();
  for (int round = 0; round < 8; ++round) {
    Real at = from;
    const Real step = (to - from) / count;
    for (int s = 0; s <= count; ++s) {
      const Real t = s == count ? to : from + s * step, v = value(t);
      if (v < best) {
        best = v;
        at = t;
      }
    }
    const Real low = std::max(from, at - step), high = std::min(to, at + step);
    from = low;
    to = high;
  }
  return best;
}

/// The least turn that takes the direction of `from`, no opposite, to that of `to`. Eigen's FromTwoVectors() brings a
/// singular value decomposition, eight seconds of compiling.
inline Eigen::Matrix3d turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d axis = from.cross(to);
  return Eigen::AngleAxisd(std::atan2(axis.norm(), from.dot(to)), axis.normalized()).toRotationMatrix();
}

inline Eigen::Vector3d random_direction(shapes::Random& random) {
  for (;;) {
    const Eigen::Vector3d d = random.point(1);
    if (d.norm() <= 1 && d.norm() > 0.1) return d.normalized();
  }
}

inline Eigen::Matrix3d random_rotation(shapes::Random& random, double largest_angle) {
  const Eigen::Vector3d axis = random_direction(random);
  return Eigen::AngleAxisd(random(-largest_angle, largest_angle), axis).toRotationMatrix();
}

inline Eigen::Isometry3d random_pose(shapes::Random& random, double reach) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = random_rotation(random, 3.1);
  pose.translation() = random.point(reach);
  return pose;
}

/// A motion from `start` that turns by at most `angle` about the body's own origin and moves by at most `way` in each
/// coordinate.
inline Motion random_motion(shapes::Random& random, const Eigen::Isometry3d& start, double angle, double way) {
  Motion motion{start, start};
  motion.end.linear() = random_rotation(random, angle) * start.linear();
  motion.end.translation() += random.point(way);
  return motion;
}

}  // namespace encage::test
