// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/convex_starts.h"

#include "cagegen/collapse/convex_hull.h"
#include "cagegen/collapse/starts.h"
#include "src/mesh/rounding.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

std::vector<Point> rows(const Vertices& vertices) {
  std::vector<Point> points;
  for (std::int64_t v = 0; v < vertices.rows(); ++v) points.push_back(vertices.row(v).transpose());
  return points;
}

/// The farthest of the points in `count` directions that are spread evenly (a Fibonacci lattice).
std::vector<Point> farthest(const std::vector<Point>& points, std::size_t count) {
  constexpr double golden_angle = 2.39996322972865332;
  std::vector<Point> found;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double angle = golden_angle * static_cast<double>(i), radius = std::sqrt(1 - z * z);
    const Point direction(radius * std::cos(angle), radius * std::sin(angle), z);
    found.push_back(*std::max_element(points.begin(), points.end(), [&](const Point& a, const Point& b) {
      return a.dot(direction) < b.dot(direction);
    }));
  }
  return found;
}

/// Drops most points that are inside the hull of the others, quickly: those well inside the hull of a few.
void drop_inner(std::vector<Point>& points) {
  constexpr std::size_t directions = 64;
  if (points.size() < 20 * directions) return;
  const auto inner = convex_hull(farthest(points, directions));
  if (!inner) return;
  const double margin = 1e-6 * bounds(*inner).diagonal().norm();
  std::vector<std::pair<Point, double>> planes;
  for (std::int64_t t = 0; t < inner->triangles.rows(); ++t) {
    const Point corner = inner->corner(t, 0);
    const Point normal = (inner->corner(t, 1) - corner).cross(inner->corner(t, 2) - corner).normalized();
    if (normal.allFinite()) planes.emplace_back(normal, normal.dot(corner) - margin);
  }
  std::erase_if(points, [&](const Point& p) {
    return std::all_of(planes.begin(), planes.end(),
                       [&](const auto& plane) { return plane.first.dot(p) < plane.second; });
  });
}

/// The vertices of the hull; all of them if it is flat.
std::vector<Point> extreme_points(const TriangleMesh& mesh) {
  std::vector<Point> points = rows(mesh.vertices);
  drop_inner(points);
  const auto hull = convex_hull(points);
  return hull ? rows(hull->vertices) : points;
}

/// Distance by which roundings of coordinates may bring a surface closer.
double rounding(const ConvexFrame& frame) {
  double largest = 0;
  for (const Point& p : frame.points) largest = std::max(largest, p.lpNorm<Eigen::Infinity>());
  return largest * std::numeric_limits<float>::epsilon();
}

/// The hull of points, rounded before the hull is taken: the result is convex, exactly. No value if it is flat.
std::optional<TriangleMesh> rounded_hull(std::vector<Point> points) {
  for (Point& p : points) p = round_to_float(p);
  return convex_hull(points);
}

std::optional<TriangleMesh> padded_hull(const ConvexFrame& frame, double padding) {
  std::vector<Point> padded;
  for (const Point& p : frame.points) {
    for (int i = 0; i < 8; ++i) {
      const Point shift(i & 1 ? padding : -padding, i & 2 ? padding : -padding, i & 4 ? padding : -padding);
      padded.push_back(p + frame.axes.transpose() * shift);
    }
  }
  return rounded_hull(std::move(padded));
}

std::optional<TriangleMesh> scaled_hull(const ConvexFrame& frame, double scale) {
  // Inside the hull, unlike the middle of the box: all of the hull moves outward.
  Point centre = Point::Zero();
  for (const Point& p : frame.points) centre += p / static_cast<double>(frame.points.size());
  std::vector<Point> scaled;
  for (const Point& p : frame.points) scaled.push_back(centre + scale * (p - centre));
  return rounded_hull(std::move(scaled));
}

/// Calls make(padding) with growing paddings, from just the clearance on, until the result is clear.
template <class Make>
TriangleMesh grow_until_clear(const Obstacle& obstacle, const ConvexFrame& frame, double clearance, Make make) {
  for (double surplus = 1e-3 * clearance + 4 * rounding(frame);; surplus *= 2) {
    const auto cage = make(clearance + surplus);
    if (cage && clear(obstacle, *cage, clearance)) return *cage;
  }
}

Eigen::AlignedBox3d box_in(const ConvexFrame& frame, double padding) {
  Eigen::AlignedBox3d box;
  for (const Point& p : frame.points) box.extend(Point(frame.axes * p));
  return {box.min().array() - padding, box.max().array() + padding};
}

}  // namespace

ConvexFrame::ConvexFrame(const TriangleMesh& mesh, double clearance) : points(extreme_points(mesh)) {
  // The search takes long with many points. Those that are farthest in some directions tell almost as much.
  constexpr std::size_t enough = 400;
  std::vector<Point> outermost = points.size() > enough ? farthest(points, enough) : points;
  // Flat points have boxes of no volume in many directions. With the clearance around them, one is the smallest.
  std::vector<Point> solid;
  for (const Point& p : outermost) {
    for (int k = 0; k < 3; ++k) {
      for (const double sign : {-1.0, 1.0}) solid.push_back(p + sign * clearance * Point::Unit(k));
    }
  }
  axes = smallest_box_axes(solid);
}

TriangleMesh hull_start(const Obstacle& obstacle, const ConvexFrame& frame, double clearance) {
  // Scaled, it keeps its number of triangles; flat and thin inputs have to be padded.
  const auto cage = scaled_hull(frame, 1.001);
  if (cage && clear(obstacle, *cage, clearance)) return *cage;
  return grow_until_clear(obstacle, frame, clearance, [&](double padding) { return padded_hull(frame, padding); });
}

TriangleMesh box_start(const Obstacle& obstacle, const ConvexFrame& frame, double clearance) {
  return grow_until_clear(obstacle, frame, clearance, [&](double padding) {
    const Eigen::AlignedBox3d box = box_in(frame, padding);
    std::vector<Point> corners;
    for (int i = 0; i < 8; ++i) {
      corners.push_back(frame.axes.transpose() * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
    }
    return rounded_hull(std::move(corners));
  });
}

TriangleMesh tetrahedron_start(const Obstacle& obstacle, const ConvexFrame& frame, double clearance) {
  const auto make = [&](double padding) -> std::optional<TriangleMesh> {
    const Eigen::AlignedBox3d box = box_in(frame, padding);
    // Two regular tetrahedra fit around a cube; the box is made one.
    std::optional<TriangleMesh> smallest;
    for (const double side : {1.0, -1.0}) {
      const std::array<Point, 4> normals = {Point(1, 1, 1), Point(1, -1, -1), Point(-1, 1, -1), Point(-1, -1, 1)};
      std::array<double, 4> offset;
      offset.fill(-std::numeric_limits<double>::infinity());
      for (const Point& p : frame.points) {
        const Point x = (frame.axes * p - box.center()).cwiseQuotient(box.sizes() / 2);
        for (int k = 0; k < 4; ++k) offset[k] = std::max(offset[k], side * normals[k].dot(x));
      }
      std::vector<Point> corners;
      for (int left_out = 0; left_out < 4; ++left_out) {
        Eigen::Matrix3d planes;
        Point at;
        for (int k = 0, row = 0; k < 4; ++k) {
          if (k == left_out) continue;
          planes.row(row) = side * normals[k].transpose();
          // The padding, in halves of the box's sides, in the direction of the normal.
          at[row++] = offset[k] + padding * (box.sizes() / 2).cwiseInverse().sum();
        }
        const Point x = planes.inverse() * at;
        corners.push_back(frame.axes.transpose() * (box.center() + x.cwiseProduct(box.sizes() / 2)));
      }
      auto tetrahedron = rounded_hull(std::move(corners));
      if (!tetrahedron) continue;
      if (!smallest || signed_volume(*tetrahedron) < signed_volume(*smallest)) smallest = std::move(tetrahedron);
    }
    return smallest;
  };
  return grow_until_clear(obstacle, frame, clearance, make);
}

}  // namespace encage::makers
