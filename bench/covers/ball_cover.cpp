// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/ball_cover.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/covers/ball_pairs.h"

namespace encage::covers {
namespace {

struct Ball {
  Eigen::Vector3f centre;
  float radius;
};

/// Nearly the smallest one: the centre walks towards the farthest point by ever shorter steps (Badoiu and Clarkson,
/// "Smaller core-sets for balls", 2003). Contains the points for certain.
Ball enclosing_ball(const Surface& surface, const std::vector<std::int32_t>& vertices) {
  constexpr int steps = 300;
  std::vector<Eigen::Vector3d> points;
  for (const std::int32_t v : vertices) points.push_back(surface.vertex(v));
  const auto farthest = [&](const Eigen::Vector3d& from) {
    return *std::max_element(points.begin(), points.end(), [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
      return (p - from).squaredNorm() < (q - from).squaredNorm();
    });
  };
  Eigen::Vector3d centre = 0.5 * (points.front() + farthest(points.front())), best = centre;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector3d point = farthest(centre);
    const double distance = (point - centre).squaredNorm();
    if (distance < least) {
      least = distance;
      best = centre;
    }
    centre += (point - centre) / (i + 2);
  }
  const Eigen::Vector3f rounded = best.cast<float>();
  const Eigen::Vector3d exact = rounded.cast<double>();
  const double radius = (farthest(exact) - exact).norm() * (1 + 1e-12);
  return {rounded, std::nextafter(static_cast<float>(radius), std::numeric_limits<float>::infinity())};
}

}  // namespace

BallCover::BallCover(const Surface& surface, std::int64_t balls) : radius_(surface.radius) {
  const CutTree cut = cut_tree(surface.tree, balls, LargestBy::diagonal);
  balls_ = cut.boxes;
  for (const std::int32_t index : cut.nodes) {
    const WideNode& boxes = surface.tree.nodes[index];
    BallNode node{};
    for (int lane = 0; lane < WideNode::width && boxes.count(lane) != WideNode::unused; ++lane) {
      const Ball ball = enclosing_ball(surface, vertices_below(surface.tree, boxes, lane));
      node.x[lane] = ball.centre.x();
      node.y[lane] = ball.centre.y();
      node.z[lane] = ball.centre.z();
      node.radius[lane] = ball.radius;
      node.child[lane] = std::max(cut.child(boxes, lane), BallNode::last);
      node.count = lane + 1;
    }
    nodes_.push_back(node);
  }
}

BallMaps::BallMaps(const std::array<AffineMap, 2>& maps) {
  for (std::size_t end = 0; end < 2; ++end) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) linear[end][i][j] = static_cast<float>(maps[end].linear(i, j));
      offset[end][i] = static_cast<float>(maps[end].offset[i]);
    }
  }
}

bool covers_apart(const BallCover& a, const BallCover& b, const PairMotion& motion, double distance) {
  double offset = 0;
  for (int end = 0; end < 2; ++end)
    offset = std::max(offset, motion.a[end].offset.norm() + motion.b[end].offset.norm());
  // Coordinates are within `size`. Each is off by 16 roundings (2^-24) of that at most, and the nearest time by so much
  // that its distance is off by as much again; a motion stretches radii by less than 1e-8.
  const double size = 4 * (a.radius() + b.radius()) + offset;
  const double gap = distance + 0x1p-16 * size + 0x1p-60;
  if (!(gap < 1e15)) return false;
  return balls_apart(a, b, {motion.a, motion.b, motion.at_rest ? 1 : 2, static_cast<float>(gap * (1 + 0x1p-22))});
}

}  // namespace encage::covers
