// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/motion/frame.h"

#include "oracles/meshes.h"
#include "oracles/sample_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

class Frames : public testing::Test {
 protected:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Pose pose(double reach) {
    Pose p = Pose::Identity();
    p.linear() = Eigen::Quaterniond(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1))
                     .normalized()
                     .toRotationMatrix();
    p.translation() = Vector(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)) * reach;
    return p;
  }
  std::minstd_rand random_{3};
};

// long double has 11 more bits: near enough to exact for these bounds.
using VectorL = Eigen::Matrix<long double, 3, 1>;
VectorL world(const Sample& s, const Pose& pose, const Vector& vertex) {
  const VectorL body = s.hierarchy.origin.cast<long double>() + vertex.cast<long double>();
  return pose.linear().cast<long double>() * body + pose.translation().cast<long double>();
}

TEST_F(Frames, BoxesHoldEveryVertexAndAreTight) {
  for (Sample s : sample_shapes(1e-4)) {
    for (const double reach : {1.0, 1e4}) {
      s.hierarchy.origin = Vector(3, 2, 1) * reach;
      const ShapePtr shape = make_shape(s.hierarchy);
      for (int i = 0; i < 50; ++i) {
        const Pose p = pose(reach), q = pose(reach);
        const Eigen::AlignedBox3d box = pose_box(*shape, p);
        Eigen::AlignedBox3d expected;
        for (std::int64_t v = 0; v < s.source.vertices.rows(); ++v) {
          const Vector x = s.source.vertices.row(v).transpose();
          const VectorL y = world(s, p, x);
          for (int k = 0; k < 3; ++k) {
            ASSERT_LE(static_cast<long double>(box.min()[k]), y[k]) << s.name;
            ASSERT_GE(static_cast<long double>(box.max()[k]), y[k]) << s.name;
          }
          expected.extend(y.cast<double>());
        }
        const double looseness = 3e-4 + 0x1p-8 * shape->outer().radius;
        EXPECT_LE((expected.min() - box.min()).maxCoeff(), looseness);
        EXPECT_LE((box.max() - expected.max()).maxCoeff(), looseness);
        EXPECT_TRUE(ball_box(*shape, p).contains(box));
        const Eigen::AlignedBox3d swept = world_box(*shape, {p, q});
        EXPECT_TRUE(swept.contains(box));
        EXPECT_TRUE(swept.contains(pose_box(*shape, q)));
      }
    }
  }
}

// No surface has few vertices: boxes of the tree stand for the body.
TEST_F(Frames, BoxesOfDetailedBodiesHoldEveryVertex) {
  for (const bool caged : {false, true}) {
    CageHierarchy hierarchy;
    hierarchy.fine = shapes::torus(1, 0.3, 60, 40);
    hierarchy.fine.vertices = hierarchy.fine.vertices.cast<float>().cast<double>().eval();
    if (caged) {
      hierarchy.levels.emplace_back().mesh = shapes::torus(1, 0.5, 60, 40);
      TriangleMesh& cage = hierarchy.levels[0].mesh;
      cage.vertices = cage.vertices.cast<float>().cast<double>().eval();
    }
    const ShapePtr shape = make_shape(hierarchy);
    for (int i = 0; i < 50; ++i) {
      const Pose p = pose(1);
      const Eigen::AlignedBox3d box = pose_box(*shape, p);
      Eigen::AlignedBox3d expected;
      for (std::int64_t v = 0; v < hierarchy.fine.vertices.rows(); ++v) {
        const Vector y = p * hierarchy.fine.vertex(static_cast<std::int32_t>(v));
        expected.extend(y);
        ASSERT_LT(box.exteriorDistance(y), 1e-12);
      }
      EXPECT_LE((expected.min() - box.min()).maxCoeff(), 0.25 * shape->fine.radius);
      EXPECT_LE((box.max() - expected.max()).maxCoeff(), 0.25 * shape->fine.radius);
    }
  }
}

TEST_F(Frames, BoxOfAnUnusablePoseIsTheWholeSpace) {
  const ShapePtr shape = make_shape(sample_shapes(0).front().hierarchy);
  Eigen::Isometry3d stretched = Eigen::Isometry3d::Identity();
  stretched.linear() *= 2;
  Eigen::Isometry3d broken = Eigen::Isometry3d::Identity();
  broken.translation().x() = std::nan("");
  for (const Eigen::Isometry3d& pose : {stretched, broken}) {
    const Eigen::AlignedBox3d box = world_box(*shape, Motion::resting(pose));
    EXPECT_TRUE(box.contains(Eigen::Vector3d::Constant(1e300)));
    EXPECT_TRUE(box.contains(Eigen::Vector3d::Constant(-1e300)));
  }
}

TEST_F(Frames, RequiredDistanceCoversTheRoundingOfFrames) {
  Sample s = sample_shapes(0)[2];
  for (const double reach : {1e-3, 1.0, 1e3, 1e6}) {
    s.hierarchy.origin = Vector(-1, 2, 0.3) * reach;
    const ShapePtr shape = make_shape(s.hierarchy);
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
      const Pose a = pose(reach);
      Pose b = pose(reach);
      b.linear() *= 1 + uniform(-1e-10, 1e-10);
      const PairFrame frame = relative_frame(*shape, a, *shape, b);
      const double distance = required_distance(*shape, a, *shape, b, 0);
      for (std::int64_t v = 0; v < s.hierarchy.fine.vertices.rows(); ++v) {
        const Vector x = s.hierarchy.fine.vertices.row(v).transpose();
        const VectorL y = a.linear().cast<long double>().transpose() * (world(s, b, x) - world(s, a, Vector::Zero()));
        const Vector error = (frame.map(x).cast<long double>() - y).cast<double>();
        worst = std::max(worst, error.norm() / distance);
      }
    }
    // Half of it, for a second use in containment.
    EXPECT_LT(worst, 0.25) << reach;
    EXPECT_GT(worst, 0) << reach;
  }
}

TEST_F(Frames, KnowsRigidPoses) {
  EXPECT_TRUE(is_usable(Pose::Identity()));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(is_usable(pose(1e6)));
  Pose stretched = Pose::Identity();
  stretched.linear()(1, 1) = 1 + 4e-10;
  EXPECT_TRUE(is_usable(stretched));
  EXPECT_GE(departure_from_rigid(stretched.linear()), 8e-10);
  stretched.linear()(1, 1) = 1 + 6e-10;
  EXPECT_FALSE(is_usable(stretched));
  Pose bad = Pose::Identity();
  bad.translation().y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_usable(bad));
}

TEST_F(Frames, BoxDistanceIsEuclidean) {
  const Eigen::AlignedBox3d a(Vector(0, 0, 0), Vector(1, 1, 1)), b(Vector(4, 5, 0), Vector(5, 6, 1));
  EXPECT_TRUE(boxes_apart(a, b, 4.999999));
  EXPECT_TRUE(boxes_apart(b, a, 4.999999));
  EXPECT_FALSE(boxes_apart(a, b, 5));
  EXPECT_FALSE(boxes_apart(a, a, 0));
  EXPECT_FALSE(boxes_apart(a, {Vector(1, 0, 0), Vector(2, 1, 1)}, 0)) << "touching";
  EXPECT_FALSE(boxes_apart(a, Eigen::AlignedBox3d(), 0)) << "an empty box proves nothing";
  EXPECT_TRUE(boxes_apart(a, {Vector(std::nextafter(1.0, 2.0), 0, 0), Vector(2, 1, 1)}, 0));
}

}  // namespace
}  // namespace encage::test
