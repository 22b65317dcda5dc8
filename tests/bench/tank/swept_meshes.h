// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/sweep.h"

#include <encage/mesh.h>
#include <encage/separated.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

// Meshes in motion, and overlaps of swept triangles by brute force.
namespace encage::tank::test {

/// Small triangles with corners of their own, all over a box.
inline TriangleMesh soup(int triangles, double triangle_size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  TriangleMesh mesh;
  mesh.vertices.resize(3 * triangles, 3);
  mesh.triangles.resize(triangles, 3);
  for (int t = 0; t < triangles; ++t) {
    const Eigen::RowVector3d centre(unit(random), 0.6 * unit(random), 0.3 * unit(random));
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector3d offset(unit(random), unit(random), unit(random));
      mesh.vertices.row(3 * t + k) = (centre + triangle_size * offset).cast<float>().cast<double>();
      mesh.triangles(t, k) = 3 * t + k;
    }
  }
  return mesh;
}

inline Eigen::Isometry3d random_pose(std::mt19937& random, double spread) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Eigen::Quaterniond rotation(unit(random), unit(random), unit(random), unit(random));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = spread * Eigen::Vector3d(unit(random), unit(random), unit(random));
  return pose;
}

/// `step`: how far the body moves and, in radians, turns.
inline Motion random_motion(std::mt19937& random, double spread, double step) {
  Motion motion{random_pose(random, spread), {}};
  motion.end = motion.start;
  motion.end.linear() *= Eigen::AngleAxisd(step, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  motion.end.translation() += random_pose(random, step).translation();
  return motion;
}

using Indices = std::vector<std::pair<std::int32_t, std::int32_t>>;

inline Indices sorted(const std::vector<TrianglePair>& pairs) {
  Indices result;
  for (const TrianglePair& pair : pairs) result.emplace_back(pair.a, pair.b);
  std::sort(result.begin(), result.end());
  return result;
}

/// By how much the slabs of two swept triangles are apart along the worst of the normals, which have the components -1,
/// 0 and 1; negative if all overlap. `normals`: 3 for boxes, 13 for 26-DOPs.
inline double gap(const Sweep& a, std::int32_t triangle_a, const Sweep& b, std::int32_t triangle_b, int normals) {
  static const double normal[13][3] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0},  {1, -1, 0}, {1, 0, 1}, {1, 0, -1},
                                       {0, 1, 1}, {0, 1, -1}, {1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};
  double worst = -1e300;
  for (int k = 0; k < normals; ++k) {
    const Eigen::Vector3d n(normal[k][0], normal[k][1], normal[k][2]);
    const auto interval = [&](const Sweep& s, std::int32_t t) {
      std::array<double, 2> range = {1e300, -1e300};
      for (int c = 0; c < 3; ++c) {
        for (const Eigen::Vector3d& p : {s.start_of(s.mesh->triangles(t, c)), s.end_of(s.mesh->triangles(t, c))}) {
          range = {std::min(range[0], n.dot(p)), std::max(range[1], n.dot(p))};
        }
      }
      return range;
    };
    const auto range_a = interval(a, triangle_a), range_b = interval(b, triangle_b);
    const double between = std::max(range_a[0] - range_b[1], range_b[0] - range_a[1]);
    worst = std::max(worst, between - (a.slack + b.slack) * n.norm());
  }
  return worst;
}

/// Every overlap is reported, once, and nothing that is farther apart than rounding to float explains.
inline void expect_overlaps(const Indices& reported, const Sweep& a, const Sweep& b, int normals) {
  ASSERT_TRUE(std::adjacent_find(reported.begin(), reported.end()) == reported.end()) << "a pair twice";
  const double rounding = 1e-5;
  for (std::int32_t s = 0; s < a.mesh->triangles.rows(); ++s) {
    for (std::int32_t t = 0; t < b.mesh->triangles.rows(); ++t) {
      const bool found = std::binary_search(reported.begin(), reported.end(), std::make_pair(s, t));
      const double apart = gap(a, s, b, t, normals);
      ASSERT_TRUE(found || apart > 0) << s << ' ' << t << " overlap by " << -apart;
      ASSERT_FALSE(found && apart > rounding) << s << ' ' << t << " are " << apart << " apart";
    }
  }
}

/// A tree against all pairs of triangles, for meshes and motions of several kinds.
template <class Tree>
void expect_brute_force(Tree& tree_a, Tree& tree_b, int normals) {
  std::mt19937 random(7);
  std::size_t reported = 0;
  for (const int triangles : {1, 3, 4, 5, 60, 400}) {
    for (const double step : {0.0, 0.01, 0.3}) {
      const Eigen::Vector3d origin(0.5, 0, -0.25);
      const BodyMesh body_a(soup(triangles, 0.05, 1), origin), body_b(soup(triangles / 2 + 1, 0.1, 2), -origin);
      const Sweep a = make_sweep(body_a, random_motion(random, 0.4, step), 0.001);
      const Sweep b = make_sweep(body_b, random_motion(random, 0.4, step), 0.001);
      tree_a.build(a);
      tree_b.build(b);
      std::vector<TrianglePair> pairs;
      Tree::overlaps(tree_a, tree_b, pairs);
      SCOPED_TRACE(testing::Message() << triangles << " triangles, step " << step);
      expect_overlaps(sorted(pairs), a, b, normals);
      reported += pairs.size();
    }
  }
  EXPECT_GT(reported, 200U);
}

/// All triangles on one spot: no split by place is possible.
template <class Tree>
void expect_coincident_triangles(Tree& tree_a, Tree& tree_b) {
  TriangleMesh mesh = soup(1, 0.1, 3);
  mesh.triangles = mesh.triangles.replicate(300, 1).eval();
  const BodyMesh body(mesh, Eigen::Vector3d::Zero());
  const Sweep sweep = make_sweep(body, {}, 0);
  tree_a.build(sweep);
  tree_b.build(sweep);
  std::vector<TrianglePair> pairs;
  Tree::overlaps(tree_a, tree_b, pairs);
  EXPECT_EQ(pairs.size(), 300U * 300U);
  const Indices all = sorted(pairs);
  EXPECT_TRUE(std::adjacent_find(all.begin(), all.end()) == all.end());
}

/// A mesh without triangles overlaps nothing.
template <class Tree>
void expect_nothing_of_an_empty_mesh(Tree& tree_a, Tree& tree_b) {
  const BodyMesh body(soup(10, 0.1, 3), Eigen::Vector3d::Zero()), empty(soup(0, 0.1, 3), Eigen::Vector3d::Zero());
  tree_a.build(make_sweep(body, {}, 0));
  tree_b.build(make_sweep(body, {}, 0));
  tree_b.build(make_sweep(empty, {}, 0));
  std::vector<TrianglePair> pairs;
  Tree::overlaps(tree_a, tree_b, pairs);
  Tree::overlaps(tree_b, tree_a, pairs);
  EXPECT_TRUE(pairs.empty());
}

}  // namespace encage::tank::test
