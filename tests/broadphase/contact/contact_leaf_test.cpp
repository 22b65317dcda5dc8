// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/contact/contact_leaf.h"

#include "broadphase/contact/nearest_point.h"
#include "broadphase/distance/triangle_distance.h"
#include "oracles/meshes.h"
#include "oracles/simd_targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

TriangleD random_triangle(shapes::Random& random) {
  TriangleD t;
  const Vector middle(random(-1, 1), random(-1, 1), random(-1, 1));
  for (Vector& corner : t) corner = middle + 1.5 * Vector(random(-1, 1), random(-1, 1), random(-1, 1));
  return t;
}

struct RandomLeaf {
  std::vector<TriangleD> triangles;
  ContactLeaf leaf;
};

/// A leaf of one to four triangles, of which every eighth is degenerate.
RandomLeaf random_leaf(shapes::Random& random) {
  RandomLeaf sample;
  sample.leaf.count = 1 + static_cast<int>(random(0, 3.999));
  for (int i = 0; i < sample.leaf.count; ++i) {
    TriangleD t = random_triangle(random);
    if (random(0, 1) < 0.125) t[2] = t[1];
    sample.triangles.push_back(t);
  }
  for (int lane = 0; lane < ContactLeaf::width; ++lane) {
    const int i = std::min(lane, sample.leaf.count - 1);
    const TriangleD& t = sample.triangles[static_cast<std::size_t>(i)];
    sample.leaf.set(lane, i, t, unit_normal(t));
  }
  return sample;
}

TEST(ContactLeaf, FindsTheNearestTriangleAndTheNearestThatFaces) {
  shapes::Random random(11);
  for (int round = 0; round < 2000; ++round) {
    const RandomLeaf sample = random_leaf(random);
    ContactVertex vertex;
    vertex.position = 1.5 * Vector(random(-1, 1), random(-1, 1), random(-1, 1));
    vertex.normal = Vector(random(-1, 1), random(-1, 1), random(-1, 1)).normalized();
    vertex.most_cosine = -0.25;
    double any = std::numeric_limits<double>::infinity(), facing = any;
    for (const TriangleD& t : sample.triangles) {
      const double squared = std::pow(nearest_in_triangle(vertex.position, t).distance, 2);
      const Vector n = unit_normal(t);
      any = std::min(any, squared);
      if (n.isZero() || n.dot(vertex.normal) < -0.25) facing = std::min(facing, squared);
    }
    const auto found = expect_same_on_all_targets([&] {
      std::vector<ContactVertex> vertices(1, vertex);
      note_nearest(sample.leaf, vertices, std::numeric_limits<double>::infinity());
      return std::tuple(vertices[0].any, vertices[0].any_triangle, vertices[0].facing, vertices[0].facing_triangle);
    });
    EXPECT_NEAR(std::get<0>(found), any, 1e-12);
    if (std::isinf(facing)) {
      EXPECT_EQ(std::get<3>(found), -1);
    } else {
      EXPECT_NEAR(std::get<2>(found), facing, 1e-12);
    }
  }
}

TEST(ContactLeaf, TrianglesThatTouchMayTouch) {
  shapes::Random random(12);
  int touching = 0, apart = 0;
  for (int round = 0; round < 2000; ++round) {
    const RandomLeaf a = random_leaf(random), b = random_leaf(random);
    for (int lane = 0; lane < a.leaf.count; ++lane) {
      const std::uint32_t bits = expect_same_on_all_targets([&] { return may_touch(a.leaf, lane, b.leaf, 1e-12); });
      EXPECT_EQ(bits >> b.leaf.count, 0U);
      for (int j = 0; j < b.leaf.count; ++j) {
        const bool touch =
            triangles_cross(a.triangles[static_cast<std::size_t>(lane)], b.triangles[static_cast<std::size_t>(j)], 0);
        const bool may = (bits >> j & 1U) != 0;
        EXPECT_TRUE(may || !touch);
        touching += touch ? 1 : 0;
        apart += may ? 0 : 1;
      }
    }
  }
  EXPECT_GT(touching, 1000);
  EXPECT_GT(apart, 1000);
}

TEST(ContactLeaf, EdgesWhosePerpendicularIsInTheRegionMayMeet) {
  shapes::Random random(13);
  const auto direction = [&] { return Vector(random(-1, 1), random(-1, 1), random(-1, 1)); };
  const auto set = [&](ContactEdges& edges, std::size_t lane) {
    const Vector along = direction();
    // Outwards from the edge's two triangles.
    const Vector out0 = along.cross(direction()).normalized(), out1 = along.cross(direction()).normalized();
    for (int i = 0; i < 3; ++i) {
      edges.along[static_cast<std::size_t>(i)][lane] = along[i];
      edges.out[0][static_cast<std::size_t>(i)][lane] = out0[i];
      edges.out[1][static_cast<std::size_t>(i)][lane] = out1[i];
    }
    edges.length[lane] = along.norm();
  };
  const auto vector = [](const ContactEdges::Vectors& v, std::size_t lane) {
    return Vector(v[0][lane], v[1][lane], v[2][lane]);
  };
  int meet = 0, not_meet = 0;
  for (int round = 0; round < 2000; ++round) {
    ContactEdges a, b;
    set(a, 0);
    const std::size_t used = 1 + static_cast<std::size_t>(random(0, 3.999));
    for (std::size_t lane = 0; lane < used; ++lane) set(b, lane);
    const std::uint32_t bits = expect_same_on_all_targets([&] { return edges_may_meet(a, 0, b, 1e-3); });
    EXPECT_EQ(bits >> used, 0U);
    for (std::size_t lane = 0; lane < used; ++lane) {
      const Vector n = vector(a.along, 0).cross(vector(b.along, lane));
      const double p = n.dot(vector(b.out[0], lane)), q = n.dot(vector(b.out[1], lane));
      const bool in_region = (p >= 0 && q >= 0) || (p <= 0 && q <= 0);
      const bool may = (bits >> lane & 1U) != 0;
      EXPECT_TRUE(may || !in_region);
      (may ? meet : not_meet) += 1;
    }
  }
  EXPECT_GT(meet, 500);
  EXPECT_GT(not_meet, 500);
}

}  // namespace
}  // namespace encage::test
