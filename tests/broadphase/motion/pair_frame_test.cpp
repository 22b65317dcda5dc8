// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/motion/pair_frame.h"

#include "oracles/sample_shapes.h"
#include "oracles/sampled.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

// long double has 11 more bits: near enough to exact for these bounds.
using VectorL = Eigen::Matrix<long double, 3, 1>;
VectorL world(const Sample& s, const Pose& pose, const Vector& vertex) {
  const VectorL body = s.hierarchy.origin.cast<long double>() + vertex.cast<long double>();
  return pose.linear().cast<long double>() * body + pose.translation().cast<long double>();
}

TEST(Frames, RequiredDistanceCoversTheRoundingOfFrames) {
  shapes::Random random(3);
  Sample s = sample_shapes(0)[2];
  for (const double reach : {1e-3, 1.0, 1e3, 1e6}) {
    s.hierarchy.origin = Vector(-1, 2, 0.3) * reach;
    LocalFrame local{s.hierarchy.origin};
    for (std::int64_t v = 0; v < s.hierarchy.fine.vertices.rows(); ++v) {
      local.radius = std::max(local.radius, s.hierarchy.fine.vertices.row(v).norm());
    }
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
      const Pose a = random_pose(random, reach);
      Pose b = random_pose(random, reach);
      b.linear() *= 1 + random(-1e-10, 1e-10);
      const AffineMap b_to_a = relative_frame(local, a, local, b);
      const double distance = required_distance(local, a, local, b, 0);
      for (std::int64_t v = 0; v < s.hierarchy.fine.vertices.rows(); ++v) {
        const Vector x = s.hierarchy.fine.vertices.row(v).transpose();
        const VectorL y = a.linear().cast<long double>().transpose() * (world(s, b, x) - world(s, a, Vector::Zero()));
        const Vector error = (b_to_a(x).cast<long double>() - y).cast<double>();
        worst = std::max(worst, error.norm() / distance);
      }
    }
    // Half of it, for a second use in containment.
    EXPECT_LT(worst, 0.25) << reach;
    EXPECT_GT(worst, 0) << reach;
  }
}

}  // namespace
}  // namespace encage::test
