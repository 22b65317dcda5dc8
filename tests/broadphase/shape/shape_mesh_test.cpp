// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/broadphase/shape/stored_samples.h"

#include <encage/distance.h>
#include <encage/manifold.h>
#include <encage/mass_properties.h>
#include <encage/shape_cache.h>
#include <encage/shape_mesh.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

std::string refused(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

void expect_same(const ShapeMesh& found, const TriangleMesh& expected, const Vector& origin) {
  EXPECT_EQ(found.origin, origin);
  ASSERT_EQ(found.vertices.size(), static_cast<std::size_t>(expected.vertices.rows()));
  ASSERT_EQ(found.triangles.size(), static_cast<std::size_t>(expected.triangles.rows()));
  for (std::size_t v = 0; v < found.vertices.size(); ++v) {
    const Vector local = expected.vertex(static_cast<std::int32_t>(v));
    ASSERT_EQ(found.local_vertex(v), local);
    ASSERT_EQ(found.vertex(v), Vector(origin + local));
  }
  for (std::size_t t = 0; t < found.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(found.triangles[t][static_cast<std::size_t>(k)],
                static_cast<std::uint32_t>(expected.triangles(static_cast<std::int64_t>(t), k)));
    }
  }
}

Pose turned_at(shapes::Random& random, double reach) {
  Pose pose = random_pose(random, reach);
  pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return pose;
}

/// The mesh of all parts, in double, in the frame of the whole.
TriangleMesh merged(const Shape& shape) {
  TriangleMesh all;
  for (std::int64_t i = 0; i < part_count(shape); ++i) {
    const PlacedPart part = shape_part(shape, i);
    EXPECT_EQ(part.first_triangle, all.triangles.rows());
    EXPECT_EQ(part.first_vertex, all.vertices.rows());
    const ShapeMesh mesh = fine_mesh(*part.shape);
    TriangleMesh placed;
    placed.vertices.resize(static_cast<Eigen::Index>(mesh.vertices.size()), 3);
    placed.triangles.resize(static_cast<Eigen::Index>(mesh.triangles.size()), 3);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      placed.vertices.row(static_cast<Eigen::Index>(v)) = (part.pose * (part.scale * mesh.vertex(v))).transpose();
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        placed.triangles(static_cast<Eigen::Index>(t), k) =
            static_cast<std::int32_t>(mesh.triangles[t][static_cast<std::size_t>(k)]);
      }
    }
    all = shapes::joined(all, placed);
  }
  return all;
}

ShapePtr random_compound(shapes::Random& random, const std::vector<Body>& bodies, int count) {
  std::vector<CompoundPart> parts;
  while (static_cast<int>(parts.size()) < count) {
    const Body& body = bodies[random.integer(static_cast<int>(bodies.size()))];
    if (!body.has_fine() || !body.solid()) continue;
    parts.push_back({body.shape, turned_at(random, 3), random(0.5, 2)});
  }
  return make_compound(parts);
}

// ---- Meshes ------------------------------------------------------------------

TEST(ShapeMeshes, AreThoseOfTheHierarchy) {
  for (Sample sample : sample_shapes(0)) {
    for (const double away : {0.0, 1e4}) {
      sample.hierarchy.origin = Vector(away, -2 * away, 0);
      const ShapePtr shape = make_shape(sample.hierarchy);
      const CageHierarchy& h = sample.hierarchy;
      expect_same(fine_mesh(*shape), h.fine, h.origin);
      for (int k = 0; k < level_count(*shape); ++k) {
        expect_same(cage_mesh(*shape, k), h.levels[static_cast<std::size_t>(k)].mesh, h.origin);
      }
      EXPECT_EQ(fine_triangles(*shape), h.fine.triangles.rows());
      EXPECT_EQ(fine_vertices(*shape), h.fine.vertices.rows());
      EXPECT_EQ(fine_error(*shape), h.fine_error);
      EXPECT_EQ(solid(*shape), h.solid);
    }
    const ShapePtr bare = make_shape(without_fine(sample).hierarchy);
    EXPECT_TRUE(fine_mesh(*bare).triangles.empty());
    EXPECT_EQ(fine_triangles(*bare), 0);
  }
}

TEST(ShapeMeshes, AreThoseOfTheFileWhateverTheLoading) {
  const StoredSamples stored;
  for (const auto& file : stored.files) {
    const CageHierarchy h = read_asset(file);
    for (const LoadMode mode : {LoadMode::map, LoadMode::copy}) {
      ShapeCache cache({std::int64_t{1} << 40, mode});
      for (const ShapePtr& shape : {load_shape(file, {}, mode), cache.load(file)}) {
        EXPECT_EQ(fine_triangles(*shape), h.fine.triangles.rows());
        const ShapeMesh mesh = fine_mesh(*shape);
        cache.clear();  // the lease keeps the mesh
        expect_same(mesh, h.fine, h.origin);
        for (int k = 0; k < level_count(*shape); ++k) {
          expect_same(cage_mesh(*shape, k), h.levels[static_cast<std::size_t>(k)].mesh, h.origin);
        }
      }
    }
  }
}

TEST(ShapeMeshes, OfCompoundsAreThoseOfTheirParts) {
  shapes::Random random(4);
  const std::vector<Body> bodies = sample_bodies();
  for (int round = 0; round < 20; ++round) {
    const ShapePtr inner = random_compound(random, bodies, 2);
    const CompoundPart parts[] = {{inner, turned_at(random, 2), 0.5}, {bodies[1].shape, turned_at(random, 2), 3}};
    const ShapePtr shape = make_compound(parts);
    ASSERT_EQ(part_count(*shape), 3);
    const TriangleMesh all = merged(*shape);
    EXPECT_EQ(all.triangles.rows(), fine_triangles(*shape));
    EXPECT_EQ(all.vertices.rows(), fine_vertices(*shape));
    for (std::int32_t t = 0; t < all.triangles.rows(); t += 7) {
      const PartTriangle of = part_triangle(*shape, t);
      EXPECT_EQ(shape_part(*shape, of.part).first_triangle + of.triangle, t);
    }
    // Numbers mean the same to queries: the triangle nearest to a far point along some direction.
    const Vector direction = random_direction(random);
    const ShapePtr probe = make_shape(shapes::cube(1e-3));
    const DistanceResult nearest = distance(*shape, Motion::resting(Pose::Identity()), *probe,
                                            Motion::resting(Pose(Eigen::Translation3d(20 * direction))));
    ASSERT_GE(nearest.triangle_a, 0);
    Vector low = Vector::Constant(1e9), high = -low;
    for (int k = 0; k < 3; ++k) {
      low = low.cwiseMin(all.corner(nearest.triangle_a, k));
      high = high.cwiseMax(all.corner(nearest.triangle_a, k));
    }
    EXPECT_LT(Eigen::AlignedBox3d(low, high).exteriorDistance(nearest.point_a), 1e-12);
  }
}

TEST(ShapeMeshes, RefuseWhatIsNotThere) {
  const ShapePtr box = make_shape(sample_shapes(0)[1].hierarchy);
  const CompoundPart parts[] = {{box}, {box, shift(3)}};
  const ShapePtr two = make_compound(parts);
  const std::string many =
      "the shape is a compound of 2 parts, which has no mesh of its own: take those of its parts, "
      "shape_part()";
  EXPECT_EQ(refused([&] { fine_mesh(*two); }), "fine mesh: " + many);
  EXPECT_EQ(refused([&] { cage_mesh(*two, 0); }), "cage: " + many);
  const std::string levels = std::to_string(level_count(*box));
  EXPECT_EQ(refused([&] { cage_mesh(*box, level_count(*box)); }),
            "cage: the level " + levels + " is out of range, there are " + levels + " levels");
  EXPECT_EQ(refused([&] { cage_mesh(*box, -1); }),
            "cage: the level -1 is out of range, there are " + levels + " levels");
  EXPECT_EQ(refused([&] { shape_part(*two, 2); }), "shape: part 2 is out of range, there are 2");
  EXPECT_EQ(refused([&] { shape_part(*box, -1); }), "shape: part -1 is out of range, there are 1");
  EXPECT_EQ(shape_part(*box, 0).shape, box.get());
}

// ---- Extent ------------------------------------------------------------------

TEST(ShapeExtents, HoldEveryPointAndAreTight) {
  shapes::Random random(6);
  const std::vector<Body> bodies = sample_bodies(1e-3);
  std::vector<ShapePtr> all;
  for (const Body& body : bodies) {
    all.push_back(body.shape);
    Sample moved = body.sample;
    moved.hierarchy.origin = Vector(1e4, 3, -1e3);
    all.push_back(make_shape(moved.hierarchy));
  }
  for (int i = 0; i < 10; ++i) all.push_back(random_compound(random, bodies, 1 + i));
  for (const ShapePtr& shape : all) {
    const Eigen::AlignedBox3d box = bounds(*shape);
    Eigen::AlignedBox3d exact;
    double farthest = 0;
    const Vector pivot = random.point(2);
    for (std::int64_t i = 0; i < part_count(*shape); ++i) {
      const PlacedPart part = shape_part(*shape, i);
      const ShapeMesh mesh = fine_mesh(*part.shape);
      const double error = part.scale * fine_error(*part.shape);
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const Vector x = part.pose * (part.scale * mesh.vertex(v));
        exact.extend(x - Vector::Constant(error)).extend(x + Vector::Constant(error));
        farthest = std::max(farthest, (x - pivot).norm() + error);
      }
    }
    if (exact.isEmpty()) continue;
    ASSERT_TRUE(box.contains(exact));
    const double reach = exact.max().norm() + exact.min().norm();
    const double excess = std::max((exact.min() - box.min()).maxCoeff(), (box.max() - exact.max()).maxCoeff());
    if (shape_part(*shape, 0).shape == shape.get()) {
      EXPECT_LE(excess, 1e-4 * exact.sizes().maxCoeff() + 1e-14 * reach);
    }
    EXPECT_GE(radius(*shape, pivot), farthest);
    EXPECT_LE(radius(*shape, pivot), 3 * farthest);
    EXPECT_EQ(correction_margin(*shape, 0.5, 3) >= 1.5 * radius(*shape), true);
  }
}

// ---- Mass --------------------------------------------------------------------

void expect_near(const MassProperties& a, const MassProperties& b, double tolerance) {
  EXPECT_NEAR(a.mass, b.mass, tolerance * b.mass);
  EXPECT_LT((a.centre - b.centre).norm(), tolerance * (b.radius + b.centre.norm()));
  EXPECT_LT((a.inertia - b.inertia).norm(), tolerance * b.inertia.norm());
  EXPECT_LT((a.moments - b.moments).norm(), tolerance * b.inertia.norm());
  EXPECT_NEAR(a.radius, b.radius, tolerance * b.radius);
}

TEST(ShapeMass, IsThatOfTheMesh) {
  int solids = 0;
  for (Sample sample : sample_shapes(0)) {
    for (const double away : {0.0, 1e3}) {
      sample.hierarchy.origin = Vector(away, -away, 0.25);
      const ShapePtr shape = make_shape(sample.hierarchy);
      if (sample.hierarchy.solid == Solid::surface_only) continue;
      TriangleMesh mesh = sample.hierarchy.fine;
      const MassProperties found = mass_properties(*shape);
      MassProperties expected = mass_properties(mesh);
      expected.centre += sample.hierarchy.origin;
      expect_near(found, expected, 1e-12);
      ++solids;
    }
  }
  EXPECT_GT(solids, 6);
}

TEST(ShapeMass, OfCompoundsIsThatOfTheirMeshesTogether) {
  shapes::Random random(9);
  const std::vector<Body> bodies = sample_bodies();
  for (int i = 0; i < 30; ++i) {
    const ShapePtr shape = random_compound(random, bodies, 1 + i % 5);
    expect_near(mass_properties(*shape), mass_properties(merged(*shape)), 1e-9);
  }
}

TEST(ShapeMass, OfShapesOnDemandIsTheSame) {
  const StoredSamples stored;
  ShapeCache cache({stored.room_for_a_pair(), LoadMode::copy});
  for (const auto& file : stored.files) {
    const ShapePtr plain = load_shape(file), on_demand = cache.load(file);
    if (solid(*plain) == Solid::surface_only) continue;
    const MassProperties a = mass_properties(*plain), b = mass_properties(*on_demand);
    EXPECT_EQ(a.mass, b.mass);
    EXPECT_LT((a.centre - b.centre).norm(), 1e-12);  // summed about another point
    cache.clear();
    EXPECT_EQ(cache.statistics().resident_meshes, 0) << "no lease is left";
  }
}

TEST(ShapeMass, NamesTheReasonOfARefusal) {
  const TriangleMesh open = sheet(4, 2, 1);
  EXPECT_EQ(refused([&] { mass_properties(*make_shape(open)); }), "mass properties: the mesh is not closed");
  const ShapePtr cages = make_shape(without_fine(sample_shapes(0)[1]).hierarchy);
  EXPECT_EQ(refused([&] { mass_properties(*cages); }), "mass properties: the shape has no fine mesh");
  const CompoundPart parts[] = {{make_shape(shapes::cube(1))}, {make_shape(open)}};
  EXPECT_EQ(refused([&] { mass_properties(*make_compound(parts)); }),
            "mass properties: part 1: the mesh is not closed");
  EXPECT_EQ(refused([&] { mass_properties(*make_shape(shapes::flipped(shapes::cube(1)))); }),
            "mass properties: the mesh encloses no positive volume");
}

// ---- Memory ------------------------------------------------------------------

TEST(ShapeMemoryUse, CountsWhatIsThere) {
  const StoredSamples stored;
  for (const auto& file : stored.files) {
    const auto size = static_cast<std::int64_t>(std::filesystem::file_size(file));
    const ShapePtr mapped = load_shape(file), copied = load_shape(file, {}, LoadMode::copy);
    EXPECT_EQ(memory_use(*mapped).mapped, size);
    EXPECT_EQ(memory_use(*copied).mapped, 0);
    EXPECT_EQ(memory_use(*copied).owned, memory_use(*mapped).owned + size);
    const std::int64_t fine = AssetView(file, Verify::cages).fine_bytes();
    for (const LoadMode mode : {LoadMode::map, LoadMode::copy}) {
      ShapeCache cache({std::int64_t{1} << 40, mode});
      const ShapePtr shape = cache.load(file);
      const ShapeMemory before = memory_use(*shape);
      EXPECT_EQ(before.mapped, mode == LoadMode::map ? size : 0);
      {
        const FineLease lease(*shape);
        EXPECT_EQ(memory_use(*shape).owned - before.owned, mode == LoadMode::copy ? fine : 0);
        EXPECT_EQ(memory_use(*shape).mapped, before.mapped);
      }
      cache.clear();
      EXPECT_EQ(memory_use(*shape).owned, before.owned);
    }
  }
}

TEST(ShapeMemoryUse, CountsOwnArraysFeaturesAndSharedPartsOnce) {
  const ShapePtr small = make_shape(shapes::sphere(1)), large = make_shape(shapes::sphere(4));
  const auto arrays = [](const Shape& shape) { return 12 * (fine_triangles(shape) + fine_vertices(shape)); };
  EXPECT_GT(memory_use(*large).owned, arrays(*large));
  EXPECT_LT(memory_use(*large).owned, 10 * arrays(*large) + 20'000);
  EXPECT_GT(memory_use(*large).owned - memory_use(*small).owned, arrays(*large) - arrays(*small));

  const std::int64_t before = memory_use(*large).owned;
  ManifoldCache cache;
  std::vector<ManifoldPoint> points(16);
  const Motion rest = Motion::resting(Pose::Identity());
  contact_manifold(*large, rest, *large, Motion::resting(shift(1.9)), {}, cache, points);
  EXPECT_GT(memory_use(*large).owned, before + 12 * fine_triangles(*large));

  const CompoundPart once[] = {{large}}, thrice[] = {{large}, {large, shift(3)}, {large, shift(6)}};
  const std::int64_t one = memory_use(*make_compound(once)).owned, three = memory_use(*make_compound(thrice)).owned;
  EXPECT_GT(one, memory_use(*large).owned);
  EXPECT_LT(three - one, 4096);
}

}  // namespace
}  // namespace encage::test
