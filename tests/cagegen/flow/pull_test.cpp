// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/pull.h"

#include "tests/cagegen/geometry/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace encage::makers {
namespace {

using shapes::Random;

Corners random_triangle(Random& random) {
  const Point centre = random.point(1.3);
  return {centre + random.point(0.1), centre + random.point(0.1), centre + random.point(0.1)};
}

/// Signed distances at the quadrature points, by the definition of the rule.
std::array<double, 3> distances(const SignedDistance& surface, const Corners& t) {
  std::array<double, 3> result;
  for (int j = 0; j < 3; ++j) {
    result[j] = surface.nearest((t[0] + t[1] + t[2] + 3 * t[j]) / 6).distance;
  }
  return result;
}

TEST(Quadrature, IntegratesQuadraticPolynomialsExactly) {
  const Corners t{Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)};
  double one = 0, x = 0, xx = 0, xy = 0;
  for (const auto& lambda : quadrature_weights) {
    const Point p = lambda[0] * t[0] + lambda[1] * t[1] + lambda[2] * t[2];
    one += 1.0 / 6;
    x += p.x() / 6;
    xx += p.x() * p.x() / 6;
    xy += p.x() * p.y() / 6;
  }
  EXPECT_NEAR(one, 1.0 / 2, 1e-15);
  EXPECT_NEAR(x, 1.0 / 6, 1e-15);
  EXPECT_NEAR(xx, 1.0 / 12, 1e-15);
  EXPECT_NEAR(xy, 1.0 / 24, 1e-15);
}

/// Central difference of a function of the corners along coordinate i of corner k.
template <class Function>
double difference(const Corners& t, int k, int i, const Function& function) {
  constexpr double h = 1e-6;
  Corners more = t, less = t;
  more[k][i] += h;
  less[k][i] -= h;
  return (function(more) - function(less)) / (2 * h);
}

TEST(Pull, IsTheGradientOfTheMissingDepthSquared) {
  Random random(9);
  const SignedDistance surface(shapes::torus(1, 0.4, 40, 20));
  int compared = 0;
  for (int i = 0; i < 400; ++i) {
    const Corners t = random_triangle(random);
    const std::array<double, 3> depth{0.1, 0.2, 0.3};
    const auto energy = [&](const Corners& c) {
      const std::array<double, 3> d = distances(surface, c);
      double sum = 0;
      for (int j = 0; j < 3; ++j) {
        const double wanted = (depth[0] + depth[1] + depth[2] + 3 * depth[j]) / 6;
        const double missing = std::max(0.0, d[j] + wanted);
        sum += missing * missing / 3;
      }
      return sum / 2;
    };
    const Pull result = pull(surface, t, depth, {0, 0, 0});
    double worst = 0;
    for (int k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        worst = std::max(worst, std::abs(difference(t, k, axis, energy) - result.jump[k][axis]));
      }
    }
    if (worst < 1e-5) ++compared;
  }
  EXPECT_GT(compared, 390);  // the others lie on the medial axis, where there is no gradient
}

TEST(Pull, HoldsTheGradientOfEquationFive) {
  Random random(10);
  const SignedDistance surface(shapes::torus(1, 0.4, 40, 20));
  int compared = 0;
  for (int i = 0; i < 400; ++i) {
    const Corners t = random_triangle(random);
    const auto phi = [&](const Corners& c) {
      const std::array<double, 3> d = distances(surface, c);
      return (d[0] + d[1] + d[2]) / 3;
    };
    // Every point misses these depths; what one more unit of depth adds is the sum of w λ g.
    const Pull less = pull(surface, t, {10, 10, 10}, {0, 0, 0});
    const Pull more = pull(surface, t, {11, 11, 11}, {0, 0, 0});
    double worst = 0;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(more.weight[k], 1.0 / 3, 1e-15);
      for (int axis = 0; axis < 3; ++axis) {
        const double gradient = more.jump[k][axis] - less.jump[k][axis];
        worst = std::max(worst, std::abs(difference(t, k, axis, phi) - gradient));
      }
    }
    if (worst < 1e-5) ++compared;
  }
  EXPECT_GT(compared, 390);
}

TEST(Pull, IsNothingWhereTheDepthIsReached) {
  const SignedDistance surface(shapes::cube(1));
  const Corners t{Point(0, 0, 0), Point(0.1, 0, 0), Point(0, 0.1, 0)};
  const Pull result = pull(surface, t, {0.5, 0.5, 0.5}, {0, 0, 0});
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(result.jump[k], Point(Point::Zero()));
    EXPECT_EQ(result.weight[k], 0);
  }
}

bool may_go(const SignedDistance& surface, const Point& p, const Point& y) {
  return may_go(surface, p, surface.nearest(p), y, surface.nearest(y));
}

TEST(MayGo, ThroughOneWallOnly) {
  const TriangleMesh low = shapes::box(Point(-5, -5, 0), Point(5, 5, 1));
  const TriangleMesh high = shapes::box(Point(-5, -5, 2), Point(5, 5, 3));
  const SignedDistance slabs(shapes::joined(low, high));
  const auto go = [&](double from, double to) { return may_go(slabs, Point(0, 0, from), Point(0, 0, to)); };
  EXPECT_TRUE(go(4, 3.5));
  EXPECT_TRUE(go(4, 2.5));
  EXPECT_TRUE(go(2.7, 2.2));
  EXPECT_TRUE(go(1.2, 0.9));
  EXPECT_TRUE(go(1.5, 2.5));
  EXPECT_FALSE(go(4, 1.5)) << "right through";
  EXPECT_FALSE(go(4, 0.5)) << "into the other one";
  EXPECT_FALSE(go(2.5, 0.5)) << "from one into the other";
  EXPECT_FALSE(go(2.5, 3.5)) << "out";
  EXPECT_FALSE(go(2.5, 1.5)) << "out";
  EXPECT_TRUE(may_go(slabs, Point(0, 0, 3.1), Point(0.3, 0, 2.6))) << "aslant";
  EXPECT_TRUE(may_go(slabs, Point(0, 0, 3), Point(0, 0, 2.5))) << "from the surface";
  EXPECT_TRUE(may_go(slabs, Point(0, 0, 2.99999), Point(0, 0, 2.5)));
}

/// Where the segment crosses triangles, as parameters.
std::vector<double> crossings(const TriangleMesh& mesh, const Point& p, const Point& y) {
  std::vector<double> found;
  for (std::int64_t i = 0; i < mesh.triangles.rows(); ++i) {
    const Corners t = shapes::corners(mesh, i);
    Eigen::Matrix3d m;
    m << t[1] - t[0], t[2] - t[0], p - y;
    const Point x = m.partialPivLu().solve(p - t[0]);
    if (x[0] >= 0 && x[1] >= 0 && x[0] + x[1] <= 1 && x[2] >= 0 && x[2] <= 1) found.push_back(x[2]);
  }
  return found;
}

TEST(MayGo, NoPathHasCrossingsFartherApartThanAnEighth) {
  Random random(11);
  const TriangleMesh thin = shapes::joined(shapes::torus(1, 0.1, 40, 12), shapes::scaled(shapes::sphere(2), 0.7));
  const SignedDistance surface(thin);
  int allowed = 0, entered = 0, refused = 0;
  for (int i = 0; i < 4000; ++i) {
    const Point p = random.point(1.2);
    const Point y = p + random.point(0.4);
    std::vector<double> crossed = crossings(thin, p, y);
    if (!may_go(surface, p, y)) {
      refused += crossed.size() > 1;
      continue;
    }
    ++allowed;
    if (crossed.empty()) continue;
    entered += crossed.size() == 1;
    const auto [first, last] = std::minmax_element(crossed.begin(), crossed.end());
    EXPECT_LE(*last - *first, 0.125 + 1e-9);
    EXPECT_LT(surface.nearest(y).distance, 0);
  }
  EXPECT_GT(allowed, 1000);
  EXPECT_GT(entered, 200);
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace encage::makers
