// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/world_box.h"

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

class PoseBoxes : public testing::Test {
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

TEST_F(PoseBoxes, BoxesHoldEveryVertexAndAreTight) {
  for (Sample s : sample_shapes(1e-4)) {
    for (const double reach : {1.0, 1e4}) {
      s.hierarchy.origin = Vector(3, 2, 1) * reach;
      const ShapePtr shape = make_shape(s.hierarchy);
      for (int i = 0; i < 50; ++i) {
        const Pose p = pose(reach), q = pose(reach);
        const Eigen::AlignedBox3d box = pose_box(shape->simple(), p);
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
        const double looseness = 3e-4 + 0x1p-8 * shape->simple().outer().radius;
        EXPECT_LE((expected.min() - box.min()).maxCoeff(), looseness);
        EXPECT_LE((box.max() - expected.max()).maxCoeff(), looseness);
        EXPECT_TRUE(ball_box(*shape, p).contains(box));
        const Eigen::AlignedBox3d swept = world_box(*shape, {p, q});
        EXPECT_TRUE(swept.contains(box));
        EXPECT_TRUE(swept.contains(pose_box(shape->simple(), q)));
      }
    }
  }
}

// No surface has few vertices: boxes of the tree stand for the body.
TEST_F(PoseBoxes, BoxesOfDetailedBodiesHoldEveryVertex) {
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
      const Eigen::AlignedBox3d box = pose_box(shape->simple(), p);
      Eigen::AlignedBox3d expected;
      for (std::int64_t v = 0; v < hierarchy.fine.vertices.rows(); ++v) {
        const Vector y = p * hierarchy.fine.vertex(static_cast<std::int32_t>(v));
        expected.extend(y);
        ASSERT_LT(box.exteriorDistance(y), 1e-12);
      }
      EXPECT_LE((expected.min() - box.min()).maxCoeff(), 0.25 * shape->simple().fine.radius);
      EXPECT_LE((box.max() - expected.max()).maxCoeff(), 0.25 * shape->simple().fine.radius);
    }
  }
}

TEST_F(PoseBoxes, BoxOfAnUnusablePoseIsTheWholeSpace) {
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

}  // namespace
}  // namespace encage::test
