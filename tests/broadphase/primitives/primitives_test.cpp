// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/broadphase/primitives/true_body.h"

#include <encage/error.h>
#include <encage/mass_properties.h>
#include <encage/primitives.h>
#include <encage/shape_mesh.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const double pi = std::acos(-1.0);

std::string refused(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

// ---- What they are made of ---------------------------------------------------

TriangleMesh copied(const Shape& shape) {
  const ShapeMesh mesh = fine_mesh(shape);
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vector x = mesh.vertex(v);
    vertices.push_back({x[0], x[1], x[2]});
  }
  for (const auto& t : mesh.triangles) {
    triangles.push_back(
        {static_cast<std::int32_t>(t[0]), static_cast<std::int32_t>(t[1]), static_cast<std::int32_t>(t[2])});
  }
  return shapes::mesh(vertices, triangles);
}

TEST(Primitives, AreSolidAndConvexAndSayTheirRadius) {
  for (const TrueBody& body : primitives()) {
    SCOPED_TRACE(body.name);
    EXPECT_EQ(convex_radius(*body.shape), static_cast<double>(body.radius));
    EXPECT_EQ(solid(*body.shape), Solid::closed);
    EXPECT_EQ(level_count(*body.shape), 0);
    const TriangleMesh mesh = copied(*body.shape);
    EXPECT_EQ(mesh.triangles.rows(), static_cast<Eigen::Index>(body.triangles.size()));
    if (body.solid) {
      EXPECT_TRUE(is_closed(mesh));
      EXPECT_GT(signed_volume(mesh), 0);
    }
  }
  EXPECT_EQ(convex_radius(*make_shape(shapes::cube(1))), 0);
  const CompoundPart parts[] = {{make_sphere(2)}, {make_sphere(3), shift(1, 0, 0), 0.5}, {make_box({1, 1, 1})}};
  EXPECT_EQ(convex_radius(*make_compound(parts)), 2);
}

TEST(Primitives, BoundsHoldThem) {
  for (const TrueBody& body : primitives()) {
    SCOPED_TRACE(body.name);
    Eigen::AlignedBox3d box;
    double reach = 0;
    for (const RealTriangle& t : body.triangles) {
      for (const Point& p : t) {
        box.extend(p.cast<double>());
        reach = std::max(reach, static_cast<double>(p.norm()));
      }
    }
    const Vector radius = Vector::Constant(static_cast<double>(body.radius));
    const Eigen::AlignedBox3d found = bounds(*body.shape);
    EXPECT_TRUE(found.contains(Eigen::AlignedBox3d(box.min() - radius, box.max() + radius)));
    EXPECT_LT((found.sizes() - box.sizes() - 2 * radius).maxCoeff(), 1e-3 + 4 * body.error);
    EXPECT_GE(encage::radius(*body.shape), reach + radius[0]);
    const Motion motion{shift(1, 2, 3), shift(2, 2, 3), 2};
    const Eigen::AlignedBox3d swept = world_box(*body.shape, motion);
    EXPECT_TRUE(swept.contains(Vector(Vector(1, 2, 3) + 2 * (box.min() - radius))));
    EXPECT_TRUE(swept.contains(Vector(Vector(2, 2, 3) + 2 * (box.max() + radius))));
  }
}

TEST(Primitives, ABallStaysItselfWhenItTurns) {
  Motion motion;
  motion.end.linear() = Eigen::AngleAxisd(1, Vector::UnitZ()).toRotationMatrix();
  EXPECT_EQ(arc_margin(*make_sphere(2), motion), 0);
  const double half = 1 - std::cos(0.5);
  EXPECT_NEAR(arc_margin(*make_capsule(Vector(-3, 0, 0), Vector(3, 0, 0), 1), motion), 3 * half, 1e-6);
}

TEST(Primitives, ACylindersErrorIsThatOfItsPrism) {
  for (const int sides : {3, 8, 64, 4096}) {
    const ShapePtr shape = make_cylinder(0.5, 2, sides);
    const double error = fine_error(*shape);
    double most = 0, least = infinity;
    const ShapeMesh mesh = fine_mesh(*shape);
    for (const auto& t : mesh.triangles) {
      Vector middle = Vector::Zero();
      for (int k = 0; k < 3; ++k) {
        const Vector a = mesh.vertex(t[static_cast<std::size_t>(k)]),
                     b = mesh.vertex(t[static_cast<std::size_t>((k + 1) % 3)]);
        EXPECT_EQ(std::abs(a.y()), 0.5);
        most = std::max(most, std::hypot(a.x(), a.z()));
        middle = 0.5 * (a + b);
        const bool side = std::hypot(a.x() - b.x(), a.z() - b.z()) < 1.01 * 2 * 2 * std::tan(pi / sides);
        if (side && (a - b).norm() > 0.9) least = std::min(least, std::hypot(middle.x(), middle.z()));
      }
    }
    if (sides > 3) {
      EXPECT_LE(2 - least, error);
    }
    EXPECT_LE(most - 2, error);
    EXPECT_LE(error, 2 * 2.6 / sides / sides * (sides == 3 ? 1.2 : 1) + 1e-6);
  }
}

// ---- Mass --------------------------------------------------------------------

/// Moments of a body of revolution about y, by summing discs.
void expect_revolved(const Shape& shape, double half, const std::function<double(double)>& radius_at) {
  const int discs = 200'000;
  double mass = 0, around = 0, across = 0;
  for (int i = 0; i < discs; ++i) {
    const double y = half * (2 * (i + 0.5) / discs - 1), r = radius_at(y);
    const double disc = pi * r * r * 2 * half / discs;
    mass += disc;
    around += disc * r * r / 2;
    across += disc * (r * r / 4 + y * y);
  }
  const MassProperties found = mass_properties(shape);
  EXPECT_NEAR(found.mass / mass, 1, 1e-8);
  EXPECT_LT(found.centre.norm(), 1e-12);
  EXPECT_NEAR(found.inertia(1, 1) / around, 1, 1e-8);
  EXPECT_NEAR(found.inertia(0, 0) / across, 1, 1e-8);
  EXPECT_NEAR(found.inertia(2, 2) / across, 1, 1e-8);
  EXPECT_LT(std::abs(found.inertia(0, 1)) + std::abs(found.inertia(0, 2)) + std::abs(found.inertia(1, 2)), 1e-12);
}

TEST(Primitives, MassesAreThoseOfTheBodyThatWasMeant) {
  expect_revolved(*make_sphere(1.5), 1.5, [](double y) { return std::sqrt(1.5 * 1.5 - y * y); });
  expect_revolved(*make_cylinder(0.5, 2, 5), 0.5, [](double) { return 2.0; });
  expect_revolved(*make_capsule(0.7, 0.4), 1.1, [](double y) {
    const double over = std::max(0.0, std::abs(y) - 0.7);
    return std::sqrt(std::max(0.0, 0.16 - over * over));
  });
  EXPECT_NEAR(mass_properties(*make_sphere(1.5)).radius, 1.5, 1e-6);

  // A capsule that is turned and far away, against its like in the middle.
  const Vector a(10, 20, 30), b(10.6, 20, 30.8);
  const MassProperties turned = mass_properties(*make_capsule(a, b, 0.4)),
                       plain = mass_properties(*make_capsule(0.5, 0.4));
  EXPECT_NEAR(turned.mass, plain.mass, 1e-12);
  EXPECT_LT((turned.centre - 0.5 * (a + b)).norm(), 1e-12);
  EXPECT_LT((turned.moments - plain.moments).norm(), 1e-12);
  EXPECT_LT((turned.inertia * (b - a) - plain.inertia(1, 1) * (b - a)).norm(), 1e-12);

  const Vector half(0.5, 0.375, 0.25);
  const MassProperties box = mass_properties(*make_box(half)), mesh = mass_properties(shapes::box(-half, half));
  EXPECT_NEAR(box.mass, mesh.mass, 1e-15);
  EXPECT_LT((box.inertia - mesh.inertia).norm(), 1e-15);
  const std::vector<Vector> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_NEAR(mass_properties(*make_convex_hull(corners)).mass, 1.0 / 6, 1e-15);
  EXPECT_NE(refused([&] { mass_properties(*make_convex_hull(corners, 0.1)); }).find("a convex hull with a radius"),
            std::string::npos);

  // A compound sums its parts.
  const CompoundPart parts[] = {{make_sphere(1), shift(2, 0, 0), 0.5}, {make_sphere(1), shift(-2, 0, 0), 0.5}};
  const MassProperties two = mass_properties(*make_compound(parts));
  const double one = 4 * pi / 3 / 8;
  EXPECT_NEAR(two.mass, 2 * one, 1e-14);
  EXPECT_NEAR(two.inertia(0, 0), 2 * one * 0.4 / 4, 1e-14);
  EXPECT_NEAR(two.inertia(1, 1), 2 * one * (0.4 / 4 + 4), 1e-13);
}

// ---- Hulls -------------------------------------------------------------------

/// Every point is within the error of the hull, which is closed, and convex but for rounding.
void expect_hull(const std::vector<Vector>& points) {
  const ShapePtr shape = make_convex_hull(points);
  const TriangleMesh mesh = copied(*shape);
  double size = 0;
  for (const Vector& p : points) size = std::max(size, (p - points[0]).norm());
  const double error = fine_error(*shape);
  EXPECT_LT(error, 1e-6 * size);
  EXPECT_TRUE(is_closed(mesh));
  std::vector<std::int32_t> label;
  EXPECT_EQ(triangle_components(mesh, label), 1);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Point a = real(mesh.corner(t, 0)), n = (real(mesh.corner(t, 1)) - a).cross(real(mesh.corner(t, 2)) - a);
    // Thin triangles look anywhere; those around them do not.
    if (n.norm() < 1e-6 * size * size) continue;
    for (const Vector& p : points)
      ASSERT_LE(static_cast<double>(n.normalized().dot(real(p) - a)), 2 * error + 1e-9 * size);
  }
  // No inner point is a vertex, and every vertex is a point.
  EXPECT_EQ(mesh.triangles.rows(), 2 * mesh.vertices.rows() - 4);
}

TEST(ConvexHulls, HoldTheirPoints) {
  shapes::Random random(1);
  for (int kind = 0; kind < 7; ++kind) {
    SCOPED_TRACE(kind);
    std::vector<Vector> points;
    for (int i = 0; i < 300; ++i) {
      const Vector p = random.point(1);
      const Vector on = p.normalized();
      const auto coarse = [](double x) { return std::round(2 * x) / 2; };
      switch (kind) {
        case 0: points.push_back(p); break;
        case 1: points.push_back(on); break;
        case 2: points.emplace_back(coarse(p[0]), coarse(p[1]), coarse(p[2])); break;
        case 3: points.push_back(1e6 * Vector(1, 2, 3) + 10 * p); break;
        case 4: points.push_back(Vector(p[0], 1e-3 * p[1], 1e-3 * p[2])); break;
        case 5: points.push_back(1e-20 * on); break;
        default:
          points.emplace_back(std::hypot(on[0], on[1]) > 0 ? on[0] / std::hypot(on[0], on[1]) : 1,
                              on[1] / std::hypot(on[0], on[1]), i % 2);
      }
    }
    expect_hull(points);
  }
  expect_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
}

TEST(ConvexHulls, HaveTheExtremePointsAsVertices) {
  shapes::Random random(2);
  std::vector<Vector> points;
  for (int i = 0; i < 60; ++i) points.push_back(random.point(1).cast<float>().cast<double>());
  const TriangleMesh mesh = copied(*make_convex_hull(points));
  // A point is extreme if it is a corner of a triangle of points that all others are below.
  std::vector<bool> extreme(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        const Vector n = (points[j] - points[i]).cross(points[k] - points[i]);
        int above = 0, below = 0;
        for (const Vector& p : points) {
          const double height = n.dot(p - points[i]);
          above += height > 1e-12 ? 1 : 0;
          below += height < -1e-12 ? 1 : 0;
        }
        if (above == 0 || below == 0) extreme[i] = extreme[j] = extreme[k] = true;
      }
    }
  }
  EXPECT_EQ(mesh.vertices.rows(), std::count(extreme.begin(), extreme.end(), true));
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const auto at = std::find(points.begin(), points.end(), Vector(mesh.vertices.row(v).transpose()));
    ASSERT_NE(at, points.end());
    EXPECT_TRUE(extreme[static_cast<std::size_t>(at - points.begin())]);
  }
}

TEST(ConvexHulls, FlatOnesNeedARadius) {
  const std::vector<Vector> point(5, Vector(1, 2, 3)),
      line = {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}, {2, 2, 2}},
      plane = {{0, 0, 0}, {1, 0, 1}, {0, 1, 0}, {1, 1, 1}, {0.5, 0.5, 0.5}};
  for (const auto* points : {&point, &line, &plane}) {
    const std::string message = refused([&] { make_convex_hull(*points); });
    EXPECT_NE(message.find(points == &point ? "the points extend over 0" : "lie in a plane"), std::string::npos)
        << message;
  }
  EXPECT_EQ(fine_triangles(*make_convex_hull(point, 0.5)), 1);
  EXPECT_NEAR(mass_properties(*make_convex_hull(point, 0.5)).mass, pi / 6, 1e-12);
  EXPECT_EQ(fine_triangles(*make_convex_hull(line, 0.5)), 1);
  EXPECT_NEAR(mass_properties(*make_convex_hull(line, 0.5)).mass, pi / 6 + std::sqrt(27) * pi / 4, 1e-12);
  EXPECT_EQ(fine_triangles(*make_convex_hull(plane, 0.5)), 2);
  EXPECT_LT(fine_error(*make_convex_hull(plane, 0.5)), 1e-6);
}

// ---- Bad input ---------------------------------------------------------------

TEST(Primitives, BadSizesAreNamed) {
  EXPECT_EQ(refused([] { make_sphere(0); }), "sphere: the radius is 0, and has to be between 1e-30 and 1e37");
  EXPECT_EQ(refused([] { make_sphere(-1); }), "sphere: the radius is -1, and has to be between 1e-30 and 1e37");
  EXPECT_EQ(refused([] { make_sphere(1e38); }), "sphere: the radius is 1e+38, and has to be between 1e-30 and 1e37");
  EXPECT_EQ(refused([] { make_sphere(nan); }), "sphere: the radius is nan, and has to be between 1e-30 and 1e37");
  EXPECT_EQ(refused([] { make_capsule(-1, 1); }), "capsule: the half length is -1, and has to be between 0 and 1e37");
  EXPECT_EQ(refused([] { make_capsule(1, 0); }), "capsule: the radius is 0, and has to be between 1e-30 and 1e37");
  EXPECT_EQ(refused([] { make_capsule(Vector(0, 0, 0), Vector(0, nan, 0), 1); }),
            "capsule: b[1] is nan, and has to be finite and at most 1e37");
  EXPECT_EQ(refused([] { make_box(Vector(1, 1, -2)); }), "box: half[2] is -2, and has to be between 1e-30 and 1e37");
  EXPECT_EQ(refused([] { make_cylinder(0, 1); }),
            "cylinder: the half height is 0, and has to be between 1e-30 and 1e37");
  EXPECT_EQ(refused([] { make_cylinder(1, 1, 2); }),
            "cylinder: the number of sides is 2, and has to be between 3 and 4096");
  EXPECT_EQ(refused([] { make_convex_hull({}); }), "convex hull: there are no points");
  const std::vector<Vector> points = {{0, 0, 0}, {1, 0, 0}, {0, 1e38, 0}, {0, 0, 1}};
  EXPECT_EQ(refused([&] { make_convex_hull(points); }),
            "convex hull: points[2][1] is 1e+38, and has to be finite and at most 1e37");
  EXPECT_EQ(refused([&] { make_convex_hull(std::span(points).first(2), -1); }),
            "convex hull: the radius is -1, and has to be between 1e-30 and 1e37");
  const ShapePtr box = make_box({1, 1, 1});
  EXPECT_EQ(refused([&] { refit_shape(*box, shapes::cube(2).vertices); }),
            "refit: a primitive, which has no vertices of its own; make it anew");
  EXPECT_EQ(refused([&] {
              scale_shape(*make_sphere(1), {1, 2, 1});
            }),
            "scale: a primitive; make it anew with other sizes");
}

}  // namespace
}  // namespace encage::test
