// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Contact points as a vector, what holds of all of them, and meshes that tests of contacts share.

#include "oracles/meshes.h"

#include <encage/manifold.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

namespace encage::test {

using Points = std::vector<ManifoldPoint>;

/// Returns the contact points, and checks what every manifold promises. `size` is that of the bodies and of their
/// distance from the origin: coordinates are off by some 1e-16 of it.
inline Points contacts(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                       const ManifoldOptions& options, ManifoldCache& cache, double size = 1) {
  ManifoldPoint room[64];
  const int count = contact_manifold(a, motion_a, b, motion_b, options, cache, room);
  Points points(room, room + count);
  EXPECT_LE(count, options.most_points);
  std::set<std::int32_t> patches;
  for (const ManifoldPoint& p : points) {
    EXPECT_TRUE(p.point_a.allFinite() && p.point_b.allFinite());
    EXPECT_NEAR(p.normal.norm(), 1, 1e-12);
    EXPECT_NEAR(p.normal.dot(p.point_a - p.point_b), p.separation, 1e-12 * size);
    EXPECT_LE(p.separation, options.margin + 1e-12 * size);
    patches.insert(p.patch);
    EXPECT_LE(std::count_if(points.begin(), points.end(), [&](const auto& q) { return q.patch == p.patch; }),
              options.most_per_patch);
  }
  if (!patches.empty()) {
    EXPECT_EQ(*patches.begin(), 0);
    EXPECT_EQ(*patches.rbegin(), static_cast<std::int32_t>(patches.size()) - 1);
  }
  return points;
}

inline Points contacts(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                       const ManifoldOptions& options = {}, double size = 1) {
  ManifoldCache cache;
  return contacts(a, motion_a, b, motion_b, options, cache, size);
}

inline Points contacts(const Shape& a, const Motion& motion_a, const HalfSpace& plane,
                       const ManifoldOptions& options = {}) {
  ManifoldCache cache;
  ManifoldPoint room[64];
  return {room, room + contact_manifold(a, motion_a, plane, options, cache, room)};
}

inline double least_separation(const Points& points) {
  double least = std::numeric_limits<double>::infinity();
  for (const ManifoldPoint& p : points) least = std::min(least, p.separation);
  return least;
}

/// The number of points whose normal is the given one.
inline int along(const Points& points, const Eigen::Vector3d& normal, double tolerance = 1e-9) {
  return static_cast<int>(std::count_if(points.begin(), points.end(), [&](const ManifoldPoint& p) {
    return (p.normal - normal.normalized()).norm() < tolerance;
  }));
}

/// A cylinder along z, of the given radius at its corners, cut into rings.
inline TriangleMesh cylinder(double radius, double half, int around, int rings) {
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> f;
  const double turn = 2 * std::acos(-1.0);
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const double angle = turn * j / around;
      v.push_back({radius * std::cos(angle), radius * std::sin(angle), half * (2.0 * i / rings - 1)});
    }
  }
  const auto id = [&](int i, int j) { return i * around + j % around; };
  const int bottom = static_cast<int>(v.size()), top = bottom + 1;
  v.push_back({0, 0, -half});
  v.push_back({0, 0, half});
  for (int j = 0; j < around; ++j) {
    for (int i = 0; i < rings; ++i) {
      f.push_back({id(i, j), id(i, j + 1), id(i + 1, j + 1)});
      f.push_back({id(i, j), id(i + 1, j + 1), id(i + 1, j)});
    }
    f.push_back({bottom, id(0, j + 1), id(0, j)});
    f.push_back({top, id(rings, j), id(rings, j + 1)});
  }
  return shapes::mesh(v, f);
}

/// A prism along z over an L whose notch has walls x = -0.375 and y = -0.375; half a unit high up and down.
inline TriangleMesh notched() {
  const double corners[6][2] = {{-1, -1}, {1, -1}, {1, -0.375}, {-0.375, -0.375}, {-0.375, 1}, {-1, 1}};
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> f;
  for (const double z : {-0.5, 0.5}) {
    for (const auto& c : corners) v.push_back({c[0], c[1], z});
  }
  for (const auto& [i, j, k] : {std::array{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}}) {
    f.push_back({i, k, j});
    f.push_back({i + 6, j + 6, k + 6});
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    f.push_back({i, j, j + 6});
    f.push_back({i, j + 6, i + 6});
  }
  return shapes::mesh(v, f);
}

/// A box whose top, z = 0, is cut into squares whose corners are moved at random in the plane, and whose diagonals run
/// either way.
inline TriangleMesh slab(shapes::Random& random, int n, double half, double thickness, double wander) {
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> f;
  const double cell = 2 * half / n;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const double x = i == 0 || i == n ? 0 : random(-wander, wander),
                   y = j == 0 || j == n ? 0 : random(-wander, wander);
      v.push_back({-half + cell * (i + x), -half + cell * (j + y), 0});
    }
  }
  const auto id = [&](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int p = id(i, j), q = id(i + 1, j), r = id(i + 1, j + 1), s = id(i, j + 1);
      if (random.integer(2) == 0) {
        f.insert(f.end(), {{p, q, r}, {p, r, s}});
      } else {
        f.insert(f.end(), {{p, q, s}, {q, r, s}});
      }
    }
  }
  // The rim, counter-clockwise, and its copy below.
  std::vector<std::int32_t> rim;
  for (int i = 0; i < n; ++i) rim.push_back(id(i, 0));
  for (int i = 0; i < n; ++i) rim.push_back(id(n, i));
  for (int i = n; i > 0; --i) rim.push_back(id(i, n));
  for (int i = n; i > 0; --i) rim.push_back(id(0, i));
  const auto below = static_cast<std::int32_t>(v.size()), count = static_cast<std::int32_t>(rim.size());
  for (const std::int32_t r : rim) v.push_back({v[r][0], v[r][1], -thickness});
  const auto middle = static_cast<std::int32_t>(v.size());
  v.push_back({0, 0, -thickness});
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t j = (i + 1) % count;
    f.insert(f.end(), {{rim[i], below + i, below + j}, {rim[i], below + j, rim[j]}, {middle, below + j, below + i}});
  }
  return shapes::mesh(v, f);
}

}  // namespace encage::test
