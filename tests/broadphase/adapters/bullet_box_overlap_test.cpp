// SPDX-License-Identifier: GPL-3.0-or-later
// The boxes of triangles against all pairs of them.
#include "broadphase/adapters/bullet/box_overlap.h"
#include "tests/broadphase/adapters/bullet_world.h"

#include <gtest/gtest.h>

#include <random>

namespace encage::bullet {
namespace {

using Box = Eigen::AlignedBox3d;

std::vector<Box> boxes(const BoxedMesh& mesh) {
  std::vector<Box> all;
  for (const auto& triangle : mesh.shape.fine.mesh.triangles) {
    Box box;
    for (const std::uint32_t v : triangle) {
      box.extend(mesh.scale * (mesh.shape.frame.origin + mesh.shape.fine.vertex(static_cast<std::int32_t>(v))));
    }
    all.emplace_back(box.min().array() - mesh.growth, box.max().array() + mesh.growth);
  }
  return all;
}

/// By how much the best of the face normals separates the boxes of any two triangles, at least; < 0: some overlap.
double gap(const std::vector<Box>& a, const std::vector<Box>& b, const Eigen::Isometry3d& b_to_a) {
  const Eigen::Matrix3d r = b_to_a.linear(), m = r.cwiseAbs();
  double least = std::numeric_limits<double>::infinity();
  for (const Box& x : a) {
    for (const Box& y : b) {
      const Eigen::Vector3d apart = b_to_a * y.center() - x.center();
      const Eigen::Vector3d own = apart.cwiseAbs() - (m * y.sizes() + x.sizes()) / 2;
      const Eigen::Vector3d across = (r.transpose() * apart).cwiseAbs() - (m.transpose() * x.sizes() + y.sizes()) / 2;
      least = std::min(least, std::max(own.maxCoeff(), across.maxCoeff()));
    }
  }
  return least;
}

Eigen::Isometry3d pose(std::minstd_rand& random, double distance) {
  const auto number = [&] { return 2 * static_cast<double>(random()) / std::minstd_rand::max() - 1; };
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = Eigen::Quaterniond(number(), number(), number(), number()).normalized().toRotationMatrix();
  result.translation() = distance * Eigen::Vector3d(number(), number(), number());
  return result;
}

TEST(BulletBoxOverlap, IsThatOfAnyTwoTriangles) {
  std::minstd_rand random(3);
  const std::vector<std::string> names = {"star", "torus", "l", "sphere"};
  int overlapping = 0, apart = 0;
  for (int i = 0; i < 160; ++i) {
    const test::Body a = test::body_named(names[static_cast<std::size_t>(i % 3)]);
    const test::Body b = test::body_named(names[static_cast<std::size_t>(i / 3 % 3)]);
    const BoxedMesh mesh_a{a.shape->simple(), 1, 0.01 * (i % 2)},
        mesh_b{b.shape->simple(), i % 5 == 0 ? 0.5 : 1, 0.02 * (i % 3)};
    const Eigen::Isometry3d b_to_a = pose(random, 3);
    const double exact = gap(boxes(mesh_a), boxes(mesh_b), b_to_a), slack = i % 7 == 0 ? 0.05 : 0;
    const bool found = boxes_may_overlap(mesh_a, mesh_b, b_to_a, slack);
    EXPECT_TRUE(found || exact > slack) << i;
    EXPECT_TRUE(!found || exact <= slack + 1e-3) << i;
    overlapping += exact <= slack;
    apart += exact > slack + 1e-3;
  }
  EXPECT_GT(overlapping, 20);
  EXPECT_GT(apart, 20);
}

// Slid apart until they hardly overlap, or hardly do not.
TEST(BulletBoxOverlap, IsRightWhereBoxesGraze) {
  std::minstd_rand random(5);
  const test::Body body = test::body_named("star");
  const BoxedMesh mesh{body.shape->simple(), 1, 0.01};
  const std::vector<Box> all = boxes(mesh);
  for (int i = 0; i < 40; ++i) {
    Eigen::Isometry3d b_to_a = pose(random, 1);
    const Eigen::Vector3d direction = b_to_a.translation().normalized();
    double near = 0, far = 8;
    while (far - near > 1e-7) {
      const double middle = (near + far) / 2;
      b_to_a.translation() = middle * direction;
      (gap(all, all, b_to_a) <= 0 ? near : far) = middle;
    }
    b_to_a.translation() = near * direction;
    EXPECT_TRUE(boxes_may_overlap(mesh, mesh, b_to_a, 0)) << i;
    b_to_a.translation() = (far + 1e-3) * direction;
    EXPECT_TRUE(!boxes_may_overlap(mesh, mesh, b_to_a, 0) || gap(all, all, b_to_a) <= 1e-4) << i;
  }
}

TEST(BulletBoxOverlap, IsAssumedWithoutFineMeshOrNumbers) {
  const test::Body body = test::body_named("star"), cages(test::without_fine(body.sample));
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation().x() = 100;
  const BoxedMesh mesh{body.shape->simple(), 1, 0},
      infinite{body.shape->simple(), 1, std::numeric_limits<double>::infinity()};
  EXPECT_FALSE(boxes_may_overlap(mesh, mesh, far, 0));
  EXPECT_TRUE(boxes_may_overlap(mesh, {cages.shape->simple(), 1, 0}, far, 0));
  EXPECT_TRUE(boxes_may_overlap(mesh, infinite, far, 0));
  far.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(boxes_may_overlap(mesh, mesh, far, 0));
}

}  // namespace
}  // namespace encage::bullet
