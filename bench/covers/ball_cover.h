// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "broadphase/separation/surface_pair.h"

#include <array>

namespace encage::covers {

/// Eight balls side by side, of the surface's local frame.
struct alignas(32) BallNode {
  static constexpr int width = MeshNode::width;
  static constexpr std::int32_t last = 0;  ///< `child` of a ball that nothing is below

  std::array<float, width> x, y, z, radius;
  std::array<std::int32_t, width> child;
  std::int32_t count;  ///< balls used, the first ones
};

/// Balls around the parts of a surface, cut by a binary tree where balls are largest: every triangle lies in one of the
/// last ones.
class BallCover {
 public:
  BallCover(const Surface& surface, std::int64_t balls);

  const std::vector<BallNode>& nodes() const { return nodes_; }
  double radius() const { return radius_; }  ///< of the surface about its local origin
  std::int64_t balls() const { return balls_; }
  std::size_t bytes() const { return nodes_.size() * sizeof(BallNode); }

 private:
  std::vector<BallNode> nodes_;
  double radius_ = 0;
  std::int64_t balls_ = 0;
};

/// True only if the surfaces in the covers are proven to stay farther apart than `distance`, which covers rounding of
/// the common frame, as for surfaces_apart(); rounding of float is covered here.
bool covers_apart(const BallCover& a, const BallCover& b, const PairMotion& motion, double distance);

}  // namespace encage::covers
