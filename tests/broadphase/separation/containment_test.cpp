// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/separation/containment.h"

#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "oracles/sample_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

TEST(Containment, AgreesWithExactWindingNumbers) {
  std::minstd_rand random(5);
  std::uniform_real_distribution<double> uniform(-1.3, 1.3);
  int inside = 0, unknown = 0, asked = 0;
  for (const Sample& s : sample_shapes(0)) {
    if (s.hierarchy.solid == Solid::surface_only) continue;
    const ShapePtr shape = make_shape(s.hierarchy);
    const ExactBody exact(Vector::Zero(), s.hierarchy.fine, Eigen::Isometry3d::Identity());
    for (int i = 0; i < 600; ++i) {
      Vector p(uniform(random), uniform(random), uniform(random));
      // Every other one shares coordinates with vertices, edges and faces.
      if (i % 2 == 0) p = (p * 5).array().round() / 5;
      // Queries ask only where the surface is farther than rounding.
      const ExactBody probe(Vector::Zero(), shapes::box(p, p), Eigen::Isometry3d::Identity());
      if (surfaces_meet(exact, probe, 1e-9)) continue;
      const int number = winding_number(exact, p);
      const Side side = locate(shape->simple().fine, p);
      ++asked;
      inside += number != 0;
      unknown += side == Side::unknown;
      if (side != Side::unknown) {
        ASSERT_EQ(side == Side::inside, number != 0) << s.name << " at " << p.transpose();
      }
    }
  }
  EXPECT_GT(inside, asked / 20);
  EXPECT_LE(unknown, asked / 1000);
}

// A crossing on an edge or a vertex must not be counted once, twice or not at all by chance.
TEST(Containment, RaysThroughEdgesAndVerticesDecideNothing) {
  int asked = 0, unknown = 0;
  for (const Sample& s : sample_shapes(0)) {
    if (s.hierarchy.solid != Solid::closed) continue;
    const ShapePtr shape = make_shape(s.hierarchy);
    const ExactBody exact(Vector::Zero(), s.hierarchy.fine, Eigen::Isometry3d::Identity());
    for (std::int64_t t = 0; t < s.hierarchy.fine.triangles.rows(); ++t) {
      const Vector vertex = s.hierarchy.fine.corner(t, 0);
      const Vector middle = 0.5 * (vertex + s.hierarchy.fine.corner(t, 1));
      for (const Vector& target : {vertex, middle}) {
        for (const WindingRay& ray : rays) {
          Vector direction;
          direction[ray.axis] = 1;
          direction[(ray.axis + 1) % 3] = ray.slope1;
          direction[(ray.axis + 2) % 3] = ray.slope2;
          for (const double length : {0.25, 0.7, 1.1}) {
            const Vector p = target - length * direction;
            const ExactBody probe(Vector::Zero(), shapes::box(p, p), Eigen::Isometry3d::Identity());
            if (surfaces_meet(exact, probe, 1e-9)) continue;
            const Side side = locate(shape->simple().fine, p);
            ++asked;
            unknown += side == Side::unknown;
            if (side != Side::unknown) {
              ASSERT_EQ(side == Side::inside, winding_number(exact, p) != 0) << s.name << " at " << p.transpose();
            }
          }
        }
      }
    }
  }
  EXPECT_GT(asked, 5'000);
  EXPECT_LE(unknown, asked / 100) << "another ray decides";
}

TEST(Containment, PointsOnTheSurfaceAreNotOutside) {
  const Sample box = sample_shapes(0)[1];
  const ShapePtr shape = make_shape(box.hierarchy);
  for (const Vector& p : {Vector(1, 0.25, 0.125), Vector(1, 1, 1), Vector(-1, 0, -1), Vector(0.3, -1, 0.9)}) {
    EXPECT_NE(locate(shape->simple().fine, p), Side::outside) << p.transpose();
  }
}

}  // namespace
}  // namespace encage::test
