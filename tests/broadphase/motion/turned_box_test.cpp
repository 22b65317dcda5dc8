// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/motion/turned_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace encage::test {
namespace {

using Box = Eigen::AlignedBox3d;
using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;
using VectorL = Eigen::Matrix<long double, 3, 1>;  // 11 more bits than double

class BodyBoxes : public testing::Test {
 protected:
  double uniform() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  Vector vector() { return Vector(uniform(), uniform(), uniform()); }
  Pose pose(double reach) {
    Pose p = Pose::Identity();
    if (random_() % 4 != 0) {
      p.linear() = Eigen::Quaterniond(uniform(), uniform(), uniform(), uniform()).normalized().toRotationMatrix();
    }
    p.translation() = vector() * reach;
    return p;
  }
  Box box(double away, double size) {
    const Vector centre = vector() * away, half = vector().cwiseAbs() * size;
    return {centre - half, centre + half};
  }
  std::minstd_rand random_{11};
};

TEST_F(BodyBoxes, TurnedBoxHoldsAllCornersAndNoMoreThanNeeded) {
  for (int i = 0; i < 20'000; ++i) {
    const double away = std::pow(10.0, 8 * uniform()), reach = std::pow(10.0, 8 * uniform());
    const Box b = box(away, std::pow(10.0, 3 * uniform()));
    const Pose p = pose(reach);
    const Box turned = turned_box(b, p);
    VectorL low = VectorL::Constant(1e300L), high = -low;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector x = b.corner(static_cast<Box::CornerType>(corner));
      const VectorL y = p.linear().cast<long double>() * x.cast<long double>() + p.translation().cast<long double>();
      low = low.cwiseMin(y);
      high = high.cwiseMax(y);
    }
    const double size = b.min().cwiseAbs().cwiseMax(b.max().cwiseAbs()).norm() + p.translation().norm();
    for (int k = 0; k < 3; ++k) {
      ASSERT_LE(static_cast<long double>(turned.min()[k]), low[k]);
      ASSERT_GE(static_cast<long double>(turned.max()[k]), high[k]);
    }
    ASSERT_LE(static_cast<double>((low - turned.min().cast<long double>()).maxCoeff()), 2e-14 * size);
    ASSERT_LE(static_cast<double>((turned.max().cast<long double>() - high).maxCoeff()), 2e-14 * size);
  }
}

long double distance_beyond(const Box& box, const HalfSpace& plane) {
  long double nearest = -static_cast<long double>(plane.offset);
  for (int k = 0; k < 3; ++k) {
    const long double n = plane.normal[k];
    nearest += std::min(n * box.min()[k], n * box.max()[k]);
  }
  return nearest / plane.normal.cast<long double>().norm();
}

TEST_F(BodyBoxes, BeyondIsOnlySaidOfBoxesFartherThanTheMargin) {
  int beyond = 0, near = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Box b = box(std::pow(10.0, 3 * uniform()), std::pow(10.0, 3 * uniform()));
    HalfSpace plane{vector().normalized() * (1 + 0.9e-9 * uniform()), 0};
    if (i % 3 == 0) plane.normal = Vector::Unit(i % 9 / 3) * (i % 2 == 0 ? 1 : -1);
    const double margin = i % 2 == 0 ? 0 : std::abs(uniform());
    // Around the place where the answer changes.
    plane.offset = static_cast<double>(distance_beyond(b, plane)) - margin;
    plane.offset += std::pow(10.0, 8 * uniform() - 8) * uniform();
    const long double distance = distance_beyond(b, plane);
    const double size = b.min().norm() + b.max().norm() + std::abs(plane.offset) + margin;
    if (box_beyond(b, plane, margin)) {
      ++beyond;
      ASSERT_GT(distance, static_cast<long double>(margin));
    } else {
      ++near;
      ASSERT_LE(static_cast<double>(distance), margin + 1e-8 * size);
    }
  }
  EXPECT_GT(beyond, 10'000);
  EXPECT_GT(near, 10'000);
}

TEST_F(BodyBoxes, NothingIsProvenOfWhatIsNotFinite) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const HalfSpace floor{Vector(0.6, 0, 0.8), -5};
  EXPECT_TRUE(box_beyond(Box(Vector::Zero(), Vector::Ones()), floor, 1));
  EXPECT_FALSE(box_beyond(Box(Vector::Constant(-infinity), Vector::Constant(infinity)), floor, 0));
  EXPECT_FALSE(box_beyond(Box(Vector(0, 0, -infinity), Vector::Ones()), floor, 0));
  EXPECT_FALSE(box_beyond(Box(Vector::Constant(std::nan("")), Vector::Ones()), floor, 0));
  EXPECT_FALSE(box_beyond(Box(Vector::Zero(), Vector::Ones()), floor, infinity));
  EXPECT_FALSE(box_beyond(Box(Vector::Zero(), Vector::Ones()), floor, std::nan("")));
}

TEST(BoxesApart, IsEuclidean) {
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
