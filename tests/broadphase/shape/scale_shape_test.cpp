// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/shape.h"
#include "oracles/body.h"
#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/broadphase/shape/stored_samples.h"

#include <encage/contact.h>
#include <encage/distance.h>
#include <encage/error.h>
#include <encage/manifold.h>
#include <encage/mass_properties.h>
#include <encage/queries.h>
#include <encage/separated.h>
#include <encage/shape_cache.h>
#include <encage/shape_mesh.h>
#include <encage/world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

const std::vector<Vector>& factors() {
  static const std::vector<Vector> all = {{2, 1, 0.5}, {-1, 1, 1}, {-1, -1, -1}, {1, -3, -0.3}, {0.1, 7, 1.0 / 3}};
  return all;
}

/// The fine mesh of a sample in the body frame, stretched; triangles turned where that mirrors.
TriangleMesh stretched_mesh(const Body& body, const Vector& scale) {
  TriangleMesh mesh = shapes::moved(body.mesh(), body.origin());
  mesh.vertices = mesh.vertices * scale.asDiagonal();
  return scale.prod() < 0 ? shapes::flipped(mesh) : mesh;
}

std::string error_of_scale(const Shape& shape, const Vector& scale) {
  try {
    scale_shape(shape, scale);
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

/// A sample with the clearances that its cages have, less a hair.
Sample certified(Sample sample) {
  const TriangleMesh* inner = &sample.source;
  for (CageLevel& level : sample.hierarchy.levels) {
    const auto a = at_time(*inner, Vector::Zero(), {}, 0), b = at_time(level.mesh, Vector::Zero(), {}, 0);
    Real least = std::numeric_limits<Real>::infinity();
    for (const RealTriangle& x : a) {
      for (const RealTriangle& y : b) {
        if (distance_bound(x, y) < least) least = std::min(least, triangle_distance(x, y));
      }
    }
    level.certificate.clearance = static_cast<double>(least) * (1 - 1e-9);
    inner = &level.mesh;
  }
  return sample;
}

TEST(ScaleShape, AnswersAsAShapeMadeOfTheStretchedMesh) {
  shapes::Random random(5);
  int apart = 0, touching = 0, hits = 0, inside = 0;
  for (const Body& body : sample_bodies()) {
    if (!body.has_fine()) continue;
    for (const Vector& scale : factors()) {
      SCOPED_TRACE(testing::Message() << body.sample.name << ", " << scale.transpose());
      const ShapePtr scaled = scale_shape(*body.shape, scale),
                     anew = make_shape(stretched_mesh(body, scale), {.hollow = body.hollow});
      const SimpleShape &simple = scaled->simple(), &twin = anew->simple();
      EXPECT_NO_THROW(check_arrays(simple.fine, "fine"));
      EXPECT_EQ(simple.solid, body.shape->simple().solid);
      EXPECT_TRUE(std::ranges::equal(simple.fine.owned, twin.fine.owned));
      ASSERT_EQ(simple.fine.parts.size(), twin.fine.parts.size());
      const double rounding = simple.fine_error + twin.fine_error;
      EXPECT_LT(rounding, 1e-5 * twin.frame.reach());
      for (std::size_t p = 0; p < simple.fine.parts.size(); ++p) {
        EXPECT_EQ(simple.fine.parts[p].closed, twin.fine.parts[p].closed);
        for (std::size_t e = 0; e < 6; ++e) {
          const auto axis = static_cast<Eigen::Index>(e / 2);
          const auto at = [&](const SimpleShape& s) {
            return s.frame.origin[axis] + s.fine.vertex(s.fine.parts[p].extremes[e])[axis];
          };
          EXPECT_NEAR(at(simple), at(twin), rounding);
        }
      }
      for (int round = 0; round < 12; ++round) {
        const Motion at = Motion::resting(random_pose(random, 1.5), random(0.5, 1.5));
        if (simple.solid == twin.solid) {
          const DistanceResult found = distance(*scaled, {}, *body.shape, at),
                               expected = distance(*anew, {}, *body.shape, at);
          EXPECT_LE(found.lower, expected.upper);
          EXPECT_GE(found.upper, expected.lower);
          (found.upper > 0 ? apart : touching) += 1;
          EXPECT_EQ(contains(*scaled, {}, at.start.translation()), contains(*anew, {}, at.start.translation()));
          inside += contains(*scaled, {}, at.start.translation()) == PointSide::inside ? 1 : 0;
        }
        const Ray ray{at.start.translation(), at.start.linear().col(0)};
        const RayResult hit = cast_ray(*scaled, {}, ray), truth = cast_ray(*anew, {}, ray);
        EXPECT_EQ(hit.answer, truth.answer);
        EXPECT_EQ(hit.hit.triangle, truth.hit.triangle);
        EXPECT_EQ(hit.hit.back_face, truth.hit.back_face);
        EXPECT_NEAR(hit.hit.t, truth.hit.t, 1e-4 * (1 + truth.hit.t));
        hits += hit.answer == RayAnswer::hit ? 1 : 0;
      }
    }
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(touching, 100);
  EXPECT_GT(hits, 50);
  EXPECT_GT(inside, 10);
}

/// Returns a cage or the fine mesh as it is stored.
ExactBody exact(const ShapeMesh& mesh, TriangleMesh& copy) {
  copy.vertices.resize(static_cast<Eigen::Index>(mesh.vertices.size()), 3);
  copy.triangles.resize(static_cast<Eigen::Index>(mesh.triangles.size()), 3);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) copy.vertices.row(v) = mesh.local_vertex(v).transpose();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) copy.triangles(t, k) = static_cast<std::int32_t>(mesh.triangles[t][k]);
  }
  return {mesh.origin, copy, Pose::Identity()};
}

/// Proves in exact arithmetic that cages hold the exact image of the source, and each other.
void expect_nested(const Sample& sample, const Vector& scale, const Shape& scaled) {
  Pose stretch = Pose::Identity();
  stretch.linear() = scale.asDiagonal();
  const Vector& origin = sample.hierarchy.origin;
  auto inner = std::make_unique<ExactBody>(origin, sample.source, stretch);
  std::vector<Vector> points;
  for (std::int32_t v = 0; v < sample.source.vertices.rows(); ++v) {
    points.emplace_back(scale.cwiseProduct(origin + sample.source.vertex(v)));
  }
  for (int k = 0; k < level_count(scaled); ++k) {
    SCOPED_TRACE(k);
    const ShapeMesh mesh = cage_mesh(scaled, k);
    TriangleMesh copy;
    auto cage = std::make_unique<ExactBody>(exact(mesh, copy));
    EXPECT_GT(signed_volume(copy), 0);
    EXPECT_FALSE(surfaces_meet(*inner, *cage, scaled.simple().clearances()[static_cast<std::size_t>(k)] * 0.999));
    for (const Vector& p : points) EXPECT_EQ(winding_number(*cage, p), 1);
    points.clear();
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) points.push_back(mesh.vertex(v));
    inner = std::move(cage);
  }
}

TEST(ScaleShape, CagesStillEnclose) {
  int kept = 0, dropped = 0;
  for (Sample sample : sample_shapes(1e-4)) {
    if (sample.hierarchy.levels.empty()) continue;
    sample = certified(sample);
    for (const Vector& far : {Vector(0, 0, 0), Vector(1000, -250.25, 0.375)}) {
      sample.hierarchy.origin = far;
      const ShapePtr shape = make_shape(sample.hierarchy);
      for (const Vector& scale : {factors()[3], Vector(1.1, -1 / 3.0, 3e-8), Vector(1.1, 1 / 3.0, 1e-44)}) {
        SCOPED_TRACE(testing::Message() << sample.name << ", " << scale.transpose());
        if (error_of_scale(*shape, scale) != "none") {
          EXPECT_EQ(sample.hierarchy.fine.triangles.rows(), 0);
          continue;
        }
        const ShapePtr scaled = scale_shape(*shape, scale);
        EXPECT_EQ(scaled->simple().clearances().size(), scaled->simple().cages.size());
        expect_nested(sample, scale, *scaled);
        kept += level_count(*scaled);
        dropped += level_count(*shape) - level_count(*scaled);
      }
      // There and back again: the clearances that are left suffice.
      const ShapePtr twice = scale_shape(*scale_shape(*shape, {3, -0.7, 1}), {1 / 3.0, 1, 0.9});
      EXPECT_EQ(level_count(*twice), level_count(*shape));
      expect_nested(sample, {3 * (1 / 3.0), -0.7, 0.9}, *twice);
    }
  }
  EXPECT_GT(kept, 40);
  EXPECT_GT(dropped, 10);
}

TEST(ScaleShape, FineErrorHoldsTheSource) {
  for (const Sample& sample : sample_shapes(1e-3)) {
    if (sample.hierarchy.fine.triangles.rows() == 0) continue;
    for (const Vector& scale : factors()) {
      SCOPED_TRACE(testing::Message() << sample.name << ", " << scale.transpose());
      const ShapePtr scaled = scale_shape(*make_shape(sample.hierarchy), scale);
      const ShapeMesh mesh = fine_mesh(*scaled);
      Real farthest = 0;
      for (std::int32_t v = 0; v < sample.source.vertices.rows(); ++v) {
        const Point source = (sample.hierarchy.origin.cast<Real>() + sample.source.vertex(v).cast<Real>())
                                 .cwiseProduct(scale.cast<Real>());
        const Point stored = mesh.origin.cast<Real>() + mesh.local_vertex(static_cast<std::size_t>(v)).cast<Real>();
        farthest = std::max(farthest, (source - stored).norm());
      }
      EXPECT_LE(farthest, fine_error(*scaled));
      EXPECT_LE(fine_error(*scaled), 1.1 * (scale.cwiseAbs().maxCoeff() * sample.hierarchy.fine_error + 1e-5));
    }
  }
}

TEST(ScaleShape, CagesWithoutACertificateAreLeftOut) {
  for (const Body& body : sample_bodies()) {
    if (level_count(*body.shape) == 0) continue;
    if (body.has_fine()) {
      EXPECT_EQ(level_count(*scale_shape(*body.shape, {1, 2, 3})), 0);
    } else {
      EXPECT_EQ(
          error_of_scale(*body.shape, {1, 2, 3}),
          "scale: no cage has a certificate whose clearance exceeds the rounding to float32, and there is no fine "
          "mesh: bake the scaled mesh");
    }
  }
}

TEST(ScaleShape, AssetsKeepTheirClearances) {
  const StoredSamples stored;
  int levels = 0;
  for (const auto& file : stored.files) {
    SCOPED_TRACE(file.filename().string());
    const ShapePtr mapped = load_shape(file), copied = load_shape(file, {}, LoadMode::copy);
    const CageHierarchy hierarchy = read_asset(file);
    const ShapePtr made = make_shape(hierarchy);
    const Vector scale(2, -1, 0.5);
    const ShapePtr from_map = scale_shape(*mapped, scale), from_copy = scale_shape(*copied, scale),
                   expected = scale_shape(*made, scale);
    EXPECT_GT(level_count(*expected), 0);
    EXPECT_EQ(from_map->simple().clearances(), expected->simple().clearances());
    EXPECT_EQ(from_copy->simple().clearances(), expected->simple().clearances());
    levels += level_count(*expected);
  }
  EXPECT_GT(levels, 3);
}

TEST(ScaleShape, PartsOfCompoundsAreStretchedInTheCompoundsFrame) {
  const std::vector<Body> all = sample_bodies();
  shapes::Random random(9);
  int apart = 0, touching = 0;
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    std::vector<CompoundPart> parts;
    TriangleMesh whole;
    while (parts.size() < 3) {
      const Body& body = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))];
      if (!body.has_fine() || !body.solid() || body.sample.hierarchy.solid != Solid::closed) continue;
      const CompoundPart part{body.shape, random_pose(random, 1.5), random(0.5, 2)};
      TriangleMesh mesh = shapes::moved(body.mesh(), body.origin());
      for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
        mesh.vertices.row(v) = (part.pose * (part.scale * mesh.vertex(v))).transpose();
      }
      whole = parts.empty() ? mesh : shapes::joined(whole, mesh);
      parts.push_back(part);
    }
    const Vector scale = round < 5 ? factors()[static_cast<std::size_t>(round)]
                                   : Vector(random(0.2, 3), random(-3, -0.2), random(0.2, 3));
    whole.vertices = whole.vertices * scale.asDiagonal();
    if (scale.prod() < 0) whole = shapes::flipped(whole);
    const ShapePtr scaled = scale_shape(*make_compound(parts), scale), twin = make_shape(whole);
    EXPECT_EQ(part_count(*scaled), 3);
    EXPECT_EQ(fine_triangles(*scaled), whole.triangles.rows());
    const Motion at = Motion::resting(random_pose(random, 4));
    const ShapePtr& other = find(all, "box").shape;
    const DistanceResult found = distance(*scaled, {}, *other, at), expected = distance(*twin, {}, *other, at);
    EXPECT_LE(found.lower, expected.upper);
    EXPECT_GE(found.upper, expected.lower);
    EXPECT_LT(found.upper - found.lower, 1e-4);
    (found.upper > 0 ? apart : touching) += 1;
    const Ray ray{at.start.translation(), -at.start.translation()};
    const RayResult hit = cast_ray(*scaled, {}, ray), truth = cast_ray(*twin, {}, ray);
    EXPECT_EQ(hit.answer, truth.answer);
    if (hit.answer == RayAnswer::hit) {
      EXPECT_NEAR(hit.hit.t, truth.hit.t, 1e-4);
    }
  }
  EXPECT_GT(apart, 10);
  EXPECT_GT(touching, 5);
}

TEST(ScaleShape, CagesOfPartsStillEnclose) {
  const Sample sample = certified(sample_shapes(1e-4)[0]);
  ASSERT_FALSE(sample.hierarchy.levels.empty());
  shapes::Random random(11);
  const ShapePtr shape = make_shape(sample.hierarchy);
  for (int round = 0; round < 10; ++round) {
    SCOPED_TRACE(round);
    const CompoundPart part{shape, random_pose(random, 2), random(0.5, 2)};
    const Vector scale(random(0.3, 2), random(-2, -0.3), random(0.3, 2));
    const ShapePtr scaled = scale_shape(*make_compound({&part, 1}), scale);
    const PlacedPart placed = shape_part(*scaled, 0);
    ASSERT_EQ(level_count(*placed.shape), level_count(*shape));
    for (int k = 0; k < level_count(*placed.shape); ++k) {
      TriangleMesh copy;
      const ExactBody stored = exact(cage_mesh(*placed.shape, k), copy);
      EXPECT_GT(signed_volume(copy), 0);
      const ExactBody cage(cage_mesh(*placed.shape, k).origin, copy, placed.pose, placed.scale);
      for (std::int32_t v = 0; v < sample.source.vertices.rows(); ++v) {
        const Vector p = part.pose * (part.scale * (sample.hierarchy.origin + sample.source.vertex(v)));
        EXPECT_EQ(winding_number(cage, scale.cwiseProduct(p)), 1);
      }
    }
  }
}

TEST(ScaleShape, PartsGoOnToShareShapes) {
  const ShapePtr box = make_shape(shapes::box({0, 0, 0}, {1, 2, 3}));
  Pose quarter = shift(5);
  quarter.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const std::vector<CompoundPart> parts = {{box}, {box, shift(0, 0, 9)}, {box, quarter}};
  const ShapePtr scaled = scale_shape(*make_compound(parts), {2, 1, 1}),
                 equal = scale_shape(*make_compound(parts), {-2, -2, -2});
  EXPECT_EQ(shape_part(*scaled, 0).shape, shape_part(*scaled, 1).shape);
  EXPECT_NE(shape_part(*scaled, 0).shape, shape_part(*scaled, 2).shape);
  EXPECT_EQ(shape_part(*equal, 0).shape, shape_part(*equal, 2).shape);
  const Eigen::AlignedBox3d first = bounds(*shape_part(*scaled, 0).shape),
                            third = bounds(*shape_part(*scaled, 2).shape);
  EXPECT_NEAR(first.max().x(), 2, 1e-3);
  EXPECT_NEAR(third.max().y(), 4, 1e-3) << "the compound's x axis is the part's y axis";
}

TEST(ScaleShape, MirroredBodiesHaveTheirOutsideOutside) {
  const TriangleMesh ball = shapes::sphere(3);
  const ShapePtr shape = make_shape(ball), ground = make_shape(shapes::box({-4, -4, -1}, {4, 4, 0}));
  ManifoldPoint points[16];
  ManifoldCache cache;
  ASSERT_GT(contact_manifold(*shape, Motion::resting(shift(0, 0, 1)), *ground, {}, {.margin = 0.1}, cache, points), 0);
  const ShapePtr mirrored = scale_shape(*shape, {-1, 1, 0.5});
  const int count =
      contact_manifold(*mirrored, Motion::resting(shift(0, 0, 0.5)), *ground, {}, {.margin = 0.01}, cache, points);
  ASSERT_GT(count, 0);
  for (int i = 0; i < count; ++i) EXPECT_NEAR(points[i].normal.z(), 1, 0.05);
  Vertices vertices = ball.vertices * Vector(-1, 1, 0.5).asDiagonal();
  EXPECT_EQ(mirrored->simple().features().twin,
            make_shape(shapes::flipped({vertices, ball.triangles}))->simple().features().twin);
  EXPECT_NEAR(mass_properties(*mirrored).mass, 0.5 * mass_properties(*shape).mass, 1e-5);
}

TEST(ScaleShape, HugeAndTinyFactors) {
  const ShapePtr ball = make_shape(shapes::sphere(2));
  for (const double factor : {1e-40, 1e-20, 1e20, 1e36}) {
    SCOPED_TRACE(factor);
    const ShapePtr scaled = scale_shape(*ball, {factor, factor, -factor});
    const DistanceResult found = distance(*scaled, {}, *scaled, Motion::resting(shift(3 * factor)), {.tolerance = 0});
    EXPECT_LE(found.lower, factor);
    EXPECT_GE(found.upper, factor * (1 - 1e-3));
  }
}

TEST(ScaleShape, FromManyThreads) {
  const ShapePtr shape = make_shape(shapes::sphere(3));
  std::vector<ShapePtr> results(4);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < results.size(); ++i) {
    threads.emplace_back([&, i] { results[i] = scale_shape(*shape, {1 + static_cast<double>(i), 1, -1}); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < results.size(); ++i) {
    const DistanceResult found =
        distance(*results[i], {}, *shape, Motion::resting(shift(2.5 + static_cast<double>(i))));
    EXPECT_NEAR(found.upper, 0.5, 0.02);
  }
}

TEST(ScaleShape, RefusesWhatCannotBeScaled) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  EXPECT_EQ(error_of_scale(*cube, {1, 2, -3}), "none");
  const std::string range = "; its size must be between 1e-50 and 1e50";
  EXPECT_EQ(error_of_scale(*cube, {1, 0, 1}), "scale: the factor along y is 0" + range);
  EXPECT_EQ(error_of_scale(*cube, {-1e51, 1, 1}), "scale: the factor along x is -1e+51" + range);
  EXPECT_EQ(error_of_scale(*cube, {1, 1, std::numeric_limits<double>::quiet_NaN()}),
            "scale: the factor along z is nan" + range);
  EXPECT_EQ(error_of_scale(*cube, {1, 1, std::numeric_limits<double>::infinity()}),
            "scale: the factor along z is inf" + range);
  EXPECT_EQ(error_of_scale(*cube, {1, 1e38, 1}),
            "scale: the fine mesh: vertex 0 has a coordinate of 1e+38, beyond 1e37: choose smaller factors or a larger "
            "unit");
  const StoredSamples stored;
  ShapeCache cache({.budget_bytes = std::int64_t{1} << 40});
  const ShapePtr cached = cache.load(stored.files.front());
  EXPECT_EQ(error_of_scale(*cached, {1, 1, 2}), "scale: the mesh of a ShapeCache; load_shape() keeps it in memory");
  const std::vector<CompoundPart> parts = {{cube}, {cached}};
  EXPECT_EQ(error_of_scale(*make_compound(parts), {1, 1, 2}),
            "scale: part 1: the mesh of a ShapeCache; load_shape() keeps it in memory");
}

/// A pose that mirrors is an error, or proves nothing; scale_shape() is what mirrors a body.
TEST(MirroredPoses, AreRefusedOrProveNothing) {
  const ShapePtr box = find(sample_bodies(), "box").shape;
  const Motion far = Motion::resting(shift(50));
  const HalfSpace below{Vector::UnitZ(), -50};
  for (int axis = 0; axis < 4; ++axis) {
    SCOPED_TRACE(axis);
    Motion mirrored = Motion::resting(shift(0.25, 0.5, 0));
    mirrored.start.linear() =
        axis < 3 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : Eigen::Matrix3d(-Eigen::Matrix3d::Identity());
    if (axis < 3) mirrored.start.linear()(axis, axis) = -1;
    mirrored.end = mirrored.start;
    ASSERT_LT(mirrored.start.linear().determinant(), 0);
    EXPECT_FALSE(is_usable(mirrored));
    const auto error_of = [&](const auto& call) -> std::string {
      try {
        call();
      } catch (const Error& error) {
        return error.what();
      }
      return "none";
    };
    const std::string why = "the start pose mirrors the body";
    for (const bool swapped : {false, true}) {
      const Motion &a = swapped ? far : mirrored, &b = swapped ? mirrored : far;
      const std::string body = swapped ? "body b: " : "body a: ";
      for (const CageUse cages : {CageUse::always, CageUse::never}) {
        const Verdict verdict = separated(*box, a, *box, b, {.cages = cages});
        EXPECT_FALSE(verdict.separated);
        EXPECT_FALSE(verdict.usable);
      }
      EXPECT_EQ(cage_distance_bound(*box, a, *box, b), 0);
      EXPECT_EQ(distance(*box, a, *box, b).lower, 0);
      EXPECT_EQ(distance(*box, a, *box, b).upper, std::numeric_limits<double>::infinity());
      const auto visit = [](TrianglePair) { return true; };
      EXPECT_EQ(error_of([&] { for_each_triangle_pair(*box, a, *box, b, 0, visit); }), "triangle pairs: " + body + why);
      EXPECT_EQ(error_of([&] {
                  const VisitEnd end = for_each_triangle_pair(*box, a, *box, b, TrianglePairOptions{}, visit);
                  EXPECT_EQ(end, VisitEnd::complete);
                }),
                "triangle pairs: " + body + why);
      EXPECT_EQ(error_of([&] { first_contact(*box, a, *box, b); }), "first contact: " + body + why);
      EXPECT_EQ(error_of([&] { PairContact contact(*box, a, *box, b); }), "first contact: " + body + why);
      ManifoldPoint points[4];
      ManifoldCache cache;
      EXPECT_EQ(error_of([&] { contact_manifold(*box, a, *box, b, {}, cache, points); }),
                "contact manifold: " + body + why);
      if (swapped) continue;
      EXPECT_EQ(error_of([&] { contact_manifold(*box, a, below, {}, cache, points); }),
                "contact manifold: " + body + why);
      EXPECT_EQ(error_of([&] { first_contact(*box, a, below); }), "first contact: " + body + why);
    }
    EXPECT_FALSE(separated(*box, mirrored, below).separated);
    EXPECT_FALSE(separated(*box, mirrored, below).usable);
    EXPECT_EQ(distance(*box, mirrored, below).lower, -std::numeric_limits<double>::infinity());
    const Vector away(9, 9, 9);
    EXPECT_EQ(cast_ray(*box, mirrored, {away, {0, 0, 1}}).answer, RayAnswer::unknown);
    EXPECT_EQ(contains(*box, mirrored, away), PointSide::unknown);
    EXPECT_EQ(closest_point(*box, mirrored, away).lower, 0);
    EXPECT_EQ(signed_distance(*box, mirrored, away).side, PointSide::unknown);
    EXPECT_TRUE(overlaps(*box, mirrored, Sphere{away, 0.1}));
    EXPECT_TRUE(overlaps(*box, mirrored, Capsule{away, away, 0.1}));
    EXPECT_TRUE(overlaps(*box, mirrored, OrientedBox{shift(9, 9, 9), {0.1, 0.1, 0.1}}));
    EXPECT_TRUE(overlaps(*box, mirrored, below));
    EXPECT_TRUE(overlaps(*box, mirrored, std::vector<Vector>{away}));
    EXPECT_EQ(world_box(*box, mirrored).max().x(), std::numeric_limits<double>::infinity());
    EXPECT_EQ(arc_margin(*box, {shift(0), mirrored.start}), std::numeric_limits<double>::infinity());
    const CompoundPart part{box, mirrored.start};
    EXPECT_EQ(error_of([&] { make_compound({&part, 1}); }), "part 0: the pose mirrors it");
    World world({.pose_tolerance = 0.1});
    const ShapeId shape = world.add_shape(box);
    EXPECT_NE(error_of([&] { world.add_body(shape, mirrored.start); }).find("mirrors"), std::string::npos);
    const BodyId body = world.add_body(shape, shift(0));
    EXPECT_NE(error_of([&] { world.set_pose(body, mirrored.start); }).find("mirrors"), std::string::npos);
    EXPECT_NE(error_of([&] { world.set_motion(body, {shift(0), mirrored.start}); }).find("mirrors"), std::string::npos);
    EXPECT_EQ(world.motion(body).start.matrix(), shift(0).matrix()) << "as it was";
  }
}

}  // namespace
}  // namespace encage::test
