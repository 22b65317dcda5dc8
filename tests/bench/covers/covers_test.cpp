// SPDX-License-Identifier: GPL-3.0-or-later
// Covers hold their mesh, and pairs of covers are judged as brute force does.

#include "bench/covers/ball_cover.h"
#include "bench/covers/box_cover.h"
#include "bench/covers/pair_lists.h"
#include "oracles/sample_shapes.h"
#include "src/tree/slab.h"
#include "tests/bench/covers/crowd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace encage::covers {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;

std::vector<Triangle> triangles(const Surface& surface) {
  std::vector<Triangle> result;
  for (const LeafTriangle& leaf : surface.tree.leaves) {
    const auto& [u, v, w] = leaf.vertices;
    result.push_back({surface.vertex(u), surface.vertex(v), surface.vertex(w)});
  }
  return result;
}

struct LastBall {
  Eigen::Vector3d centre;
  double radius;
};

LastBall ball(const BallNode& node, int lane) {
  return {Eigen::Vector3f(node.x[lane], node.y[lane], node.z[lane]).cast<double>(),
          static_cast<double>(node.radius[lane])};
}

std::vector<LastBall> last_balls(const BallCover& cover) {
  std::vector<LastBall> balls;
  for (const BallNode& node : cover.nodes()) {
    for (int lane = 0; lane < node.count; ++lane) {
      if (node.child[lane] == BallNode::last) balls.push_back(ball(node, lane));
    }
  }
  return balls;
}

/// Whether a way down leads through balls that all contain the triangle.
bool holds(const BallCover& cover, std::int32_t index, const Triangle& triangle) {
  const BallNode& node = cover.nodes()[index];
  for (int lane = 0; lane < node.count; ++lane) {
    const LastBall b = ball(node, lane);
    const bool inside = std::all_of(triangle.begin(), triangle.end(), [&](const Eigen::Vector3d& corner) {
      return (corner - b.centre).norm() <= b.radius;
    });
    if (inside && (node.child[lane] == BallNode::last || holds(cover, node.child[lane], triangle))) return true;
  }
  return false;
}

bool lane_holds(const MeshTree& tree, const MeshNode& node, int lane, const Triangle& triangle) {
  return std::all_of(triangle.begin(), triangle.end(), [&](const Eigen::Vector3d& corner) {
    Eigen::Vector3d place;
    for (int axis = 0; axis < 3; ++axis) {
      place[axis] = tree.grid.place(axis, corner[axis]);
      if (place[axis] < node.lower[axis][lane] - 1e-3 || place[axis] > node.upper[axis][lane] + 1e-3) return false;
    }
    const double height = Slab::height({node.normal[0][lane], node.normal[1][lane], node.normal[2][lane]}, place);
    return MeshNode::slab_unit * node.slab_lower[lane] <= height &&
           height <= MeshNode::slab_unit * node.slab_upper[lane];
  });
}

bool holds(const BoxCover& cover, std::int32_t index, const Triangle& triangle) {
  const MeshNode& node = cover.tree().nodes[index];
  for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
    if (!lane_holds(cover.tree(), node, lane, triangle)) continue;
    if (node.count(lane) > 0 || holds(cover, node.child(lane), triangle)) return true;
  }
  return false;
}

template <class Cover>
void expect_covered(const Surface& surface, std::int64_t size) {
  const Cover cover(surface, size);
  std::int64_t missing = 0;
  for (const Triangle& triangle : triangles(surface)) missing += holds(cover, 0, triangle) ? 0 : 1;
  EXPECT_EQ(missing, 0) << size;
}

TEST(Covers, HoldEveryTriangle) {
  for (const encage::test::Sample& sample : encage::test::large_sample_shapes(0)) {
    SCOPED_TRACE(sample.name);
    const ShapePtr shape = make_shape(sample.hierarchy);
    for (const std::int64_t size : {1, 20, 100, 1'000'000}) {
      expect_covered<BallCover>(shape->simple().fine, size);
      expect_covered<BoxCover>(shape->simple().fine, size);
    }
  }
}

TEST(Covers, AreAsLargeAsAsked) {
  const ShapePtr shape = make_shape(encage::test::large_sample_shapes(0).front().hierarchy);
  for (const std::int64_t size : {20, 100, 200}) {
    const BallCover balls(shape->simple().fine, size);
    EXPECT_EQ(balls.balls(), size);
    EXPECT_EQ(last_balls(balls).size(), static_cast<std::size_t>(size));
    const BoxCover boxes(shape->simple().fine, size);
    EXPECT_GE(boxes.boxes(), size);
    EXPECT_LT(boxes.boxes(), size + MeshNode::width);
  }
}

/// The least gap of two last balls at some times of the step.
double least_gap(const std::vector<LastBall>& balls, const PairMotion& motion) {
  double least = std::numeric_limits<double>::infinity();
  const int times = motion.at_rest ? 1 : 17;
  for (int i = 0; i < times; ++i) {
    const double t = i / 16.0;
    std::vector<Eigen::Vector3d> at_a, at_b;
    for (const LastBall& b : balls) {
      at_a.emplace_back((1 - t) * motion.a[0](b.centre) + t * motion.a[1](b.centre));
      at_b.emplace_back((1 - t) * motion.b[0](b.centre) + t * motion.b[1](b.centre));
    }
    for (std::size_t k = 0; k < balls.size(); ++k) {
      for (std::size_t l = 0; l < balls.size(); ++l) {
        least = std::min(least, (at_a[k] - at_b[l]).norm() - balls[k].radius - balls[l].radius);
      }
    }
  }
  return least;
}

TEST(BallCovers, AreApartWhereBruteForceSaysSo) {
  const ShapePtr shape = make_shape(encage::test::large_sample_shapes(0).front().hierarchy);
  const BallCover cover(shape->simple().fine, 60);
  const std::vector<LastBall> balls = last_balls(cover);
  for (const bool moving : {false, true}) {
    int apart = 0, near = 0;
    for (const auto& list : make_pairs(*shape, test::crowd(20, 0.1), 2, moving)) {
      for (const PairCase& pair : list) {
        const double gap = least_gap(balls, pair.motion);
        const bool answer = covers_apart(cover, cover, pair.motion, pair.distance);
        // Between two of the times, a little less.
        if (gap > (moving ? 0.1 : 1e-3)) {
          EXPECT_TRUE(answer) << gap;
        }
        ++(answer ? apart : near);
      }
    }
    EXPECT_GT(apart, 3);
    EXPECT_GT(near, 3);
  }
}

TEST(Covers, SayMaybeWhereNothingIsProven) {
  const ShapePtr shape = make_shape(encage::test::large_sample_shapes(0).front().hierarchy);
  const Motion here = Motion::resting(Eigen::Isometry3d::Identity());
  const Motion far = Motion::resting(Eigen::Isometry3d(Eigen::Translation3d(100, 0, 0)));
  const BallCover cover(shape->simple().fine, 60);
  EXPECT_TRUE(covers_apart(cover, cover, pair_motion(*shape, here, *shape, far), 1));
  EXPECT_FALSE(covers_apart(cover, cover, pair_motion(*shape, here, *shape, far), 101));
  EXPECT_FALSE(covers_apart(cover, cover, pair_motion(*shape, here, *shape, far), 1e20));
}

}  // namespace
}  // namespace encage::covers
