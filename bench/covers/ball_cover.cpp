// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/ball_cover.h"

#include "bench/covers/ball_pairs.h"
#include "src/tree/bvh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace encage::covers {
namespace {

struct Ball {
  Eigen::Vector3f centre;
  float radius;
};

/// Nearly the smallest one: the centre walks towards the farthest point by ever shorter steps (Badoiu and Clarkson,
/// "Smaller core-sets for balls", 2003). Contains the points for certain.
Ball enclosing_ball(const std::vector<Eigen::Vector3d>& points) {
  constexpr int steps = 100;
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
  // Rounding to float moves the centre by less than 2^-23 of its size.
  const double radius = ((farthest(best) - best).norm() + 0x1p-23 * best.norm()) * (1 + 0x1p-22);
  return {best.cast<float>(), std::nextafter(static_cast<float>(radius), std::numeric_limits<float>::infinity())};
}

TriangleMesh mesh_of(const Surface& surface) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(surface.mesh.vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(surface.mesh.triangles.size()), 3);
  for (std::size_t v = 0; v < surface.mesh.vertices.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) mesh.vertices(v, i) = static_cast<double>(surface.mesh.vertices[v][i]);
  }
  for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      mesh.triangles(t, i) = static_cast<std::int32_t>(surface.mesh.triangles[t][i]);
    }
  }
  return mesh;
}

/// A binary tree, opened where balls are largest.
class Opened {
 public:
  Opened(const Surface& surface, std::int64_t balls)
      : mesh_(mesh_of(surface)), tree_(build_bvh(mesh_)), balls_(tree_.nodes.size()), open_(tree_.nodes.size(), false) {
    using Largest = std::pair<float, std::int32_t>;
    std::priority_queue<Largest> closed;
    const auto add = [&](std::int32_t n) {
      balls_[n] = enclosing_ball(points_below(n));
      if (!tree_.nodes[n].leaf()) closed.emplace(balls_[n].radius, -n);
    };
    add(0);
    for (count_ = 1; count_ < balls && !closed.empty(); ++count_) {
      const std::int32_t n = -closed.top().second;
      closed.pop();
      open_[n] = true;
      add(tree_.nodes[n].first);
      add(tree_.nodes[n].first + 1);
    }
  }

  std::int64_t count() const { return count_; }
  const Ball& ball(std::int32_t n) const { return balls_[n]; }
  bool open(std::int32_t n) const { return open_[n]; }

  /// Up to eight below a node that together have all that is below it.
  std::vector<std::int32_t> lanes(std::int32_t root) const {
    std::vector<std::int32_t> lanes{root};
    while (lanes.size() < BallNode::width) {
      std::int32_t* largest = nullptr;
      for (std::int32_t& n : lanes) {
        if (open_[n] && (largest == nullptr || balls_[n].radius > balls_[*largest].radius)) largest = &n;
      }
      if (largest == nullptr) break;
      const std::int32_t first = tree_.nodes[*largest].first;
      *largest = first;
      lanes.push_back(first + 1);
    }
    return lanes;
  }

 private:
  std::vector<Eigen::Vector3d> points_below(std::int32_t n) const {
    std::int32_t left = n, right = n;
    while (!tree_.nodes[left].leaf()) left = tree_.nodes[left].first;
    while (!tree_.nodes[right].leaf()) right = tree_.nodes[right].first + 1;
    std::vector<std::int32_t> vertices;
    for (std::int32_t i = tree_.nodes[left].first; i < tree_.nodes[right].first + tree_.nodes[right].count; ++i) {
      for (int k = 0; k < 3; ++k) vertices.push_back(mesh_.triangles(tree_.order[i], k));
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    std::vector<Eigen::Vector3d> points;
    for (const std::int32_t v : vertices) points.emplace_back(mesh_.vertices.row(v));
    return points;
  }

  TriangleMesh mesh_;
  Bvh tree_;
  std::vector<Ball> balls_;
  std::vector<bool> open_;
  std::int64_t count_ = 0;
};

}  // namespace

BallCover::BallCover(const Surface& surface, std::int64_t balls) : radius_(surface.radius) {
  const Opened opened(surface, balls);
  balls_ = opened.count();
  nodes_.emplace_back();
  std::queue<std::pair<std::size_t, std::int32_t>> unopened;
  unopened.emplace(0, 0);
  while (!unopened.empty()) {
    const auto [place, root] = unopened.front();
    unopened.pop();
    BallNode node{};
    for (const std::int32_t n : opened.lanes(root)) {
      const Ball& ball = opened.ball(n);
      const int lane = node.count++;
      node.x[lane] = ball.centre.x();
      node.y[lane] = ball.centre.y();
      node.z[lane] = ball.centre.z();
      node.radius[lane] = ball.radius;
      if (!opened.open(n)) continue;
      node.child[lane] = static_cast<std::int32_t>(nodes_.size());
      unopened.emplace(nodes_.size(), n);
      nodes_.emplace_back();
    }
    nodes_[place] = node;
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
