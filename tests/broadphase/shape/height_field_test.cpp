// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/shape.h"
#include "oracles/body.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/src/asset/forge.h"

#include <encage/contact.h>
#include <encage/distance.h>
#include <encage/height_field.h>
#include <encage/manifold.h>
#include <encage/queries.h>
#include <encage/separated.h>
#include <encage/shape_mesh.h>
#include <encage/world_contacts.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <thread>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

constexpr float hole = std::numeric_limits<float>::quiet_NaN();

/// A field that owns its heights.
struct Field {
  std::vector<float> heights;
  HeightField field;
  HeightFieldOptions options;

  Field(std::int32_t columns, std::int32_t rows, double spacing) : heights(static_cast<std::size_t>(columns) * rows) {
    field.columns = columns;
    field.rows = rows;
    field.spacing_x = field.spacing_y = static_cast<float>(spacing);
  }
  float& at(std::int32_t column, std::int32_t row) {
    return heights[static_cast<std::size_t>(row) * field.columns + column];
  }
  ShapePtr make() {
    field.heights = heights;
    return make_height_field(field, options);
  }
  Vector vertex(std::int32_t column, std::int32_t row) {
    return field.origin + Vector(column * static_cast<double>(field.spacing_x),
                                 row * static_cast<double>(field.spacing_y), static_cast<double>(at(column, row)));
  }
};

/// The corners of a cell's triangle, written down a second time.
std::array<std::array<std::int32_t, 2>, 3> corners(const Field& f, std::int32_t i, std::int32_t j, int half) {
  const CellDiagonal d = f.options.diagonal;
  const bool rising = d == CellDiagonal::rising || (d == CellDiagonal::alternating && (i + j) % 2 == 0);
  if (rising && half == 0) return {{{i, j}, {i + 1, j}, {i + 1, j + 1}}};
  if (rising) return {{{i, j}, {i + 1, j + 1}, {i, j + 1}}};
  if (half == 0) return {{{i, j}, {i + 1, j}, {i, j + 1}}};
  return {{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
}

/// The same triangles as a mesh, row by row.
struct Twin {
  TriangleMesh mesh;
  std::vector<std::int64_t> numbers;  ///< HeightCell::number of its triangles
  ShapePtr shape;

  explicit Twin(Field& f) {
    mesh.vertices.resize(f.field.columns * f.field.rows, 3);
    for (std::int32_t j = 0; j < f.field.rows; ++j) {
      for (std::int32_t i = 0; i < f.field.columns; ++i) {
        Vector v = f.vertex(i, j);
        if (std::isnan(v.z())) v = f.vertex(0, 0).allFinite() ? f.vertex(0, 0) : f.field.origin;
        mesh.vertices.row(j * f.field.columns + i) = v.transpose();
      }
    }
    std::vector<std::array<std::int32_t, 3>> triangles;
    for (std::int32_t j = 0; j + 1 < f.field.rows; ++j) {
      for (std::int32_t i = 0; i + 1 < f.field.columns; ++i) {
        for (int half = 0; half < 2; ++half) {
          std::array<std::int32_t, 3> t;
          bool whole = true;
          for (std::size_t k = 0; k < 3; ++k) {
            const auto [x, y] = corners(f, i, j, half)[k];
            whole = whole && !std::isnan(f.at(x, y));
            t[k] = y * f.field.columns + x;
          }
          if (!whole) continue;
          triangles.push_back(t);
          numbers.push_back(2 * (static_cast<std::int64_t>(j) * (f.field.columns - 1) + i) + half);
        }
      }
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) mesh.triangles(static_cast<Eigen::Index>(t), k) = triangles[t][k];
    }
    shape = make_shape(mesh, {.hollow = true});
  }
  std::array<Vector, 3> triangle(std::int64_t t) const {
    const auto corner = [&](int k) -> Vector { return mesh.vertices.row(mesh.triangles(t, k)).transpose(); };
    return {corner(0), corner(1), corner(2)};
  }
};

/// Hills in steps that float32 holds exactly, with `holes` of a hundred samples missing.
Field hills(std::int32_t columns, std::int32_t rows, std::uint32_t seed, int holes = 0, double spacing = 0.5) {
  shapes::Random random(seed);
  Field f(columns, rows, spacing);
  f.options.diagonal = static_cast<CellDiagonal>(seed % 3);
  f.field.origin = Vector(-0.5 * columns, 3, 1) * spacing;
  for (std::int32_t j = 0; j < rows; ++j) {
    for (std::int32_t i = 0; i < columns; ++i) {
      const double wave = 1.5 * std::sin(0.21 * i) * std::cos(0.17 * j) + random(0, 0.15);
      f.at(i, j) = static_cast<float>(std::ldexp(std::round(std::ldexp(wave, 14)), -14) * spacing);
      if (random.integer(100) < holes) f.at(i, j) = hole;
    }
  }
  return f;
}

std::vector<Field> fields() {
  std::vector<Field> all;
  all.push_back(hills(2, 2, 0));
  all.push_back(hills(33, 33, 1));
  all.push_back(hills(65, 70, 2));
  all.push_back(hills(34, 100, 3, 8));
  all.push_back(hills(80, 66, 4, 30));
  all.push_back(hills(70, 70, 5, 0, 0x1p-40));
  all.push_back(hills(70, 40, 6, 3, 0x1p40));
  Field flat(97, 97, 1);
  flat.options.diagonal = CellDiagonal::alternating;
  all.push_back(std::move(flat));
  return all;
}

// ---- Meshes ----------------------------------------------------------------

TEST(HeightFields, TilesHaveTheTrianglesOfTheCells) {
  for (Field& f : fields()) {
    const ShapePtr shape = f.make();
    const Twin twin(f);
    EXPECT_EQ(fine_error(*shape), 0);
    EXPECT_EQ(solid(*shape), Solid::surface_only);
    ASSERT_EQ(fine_triangles(*shape), twin.mesh.triangles.rows());
    std::map<std::int64_t, std::int64_t> twin_of;
    for (std::size_t t = 0; t < twin.numbers.size(); ++t) twin_of[twin.numbers[t]] = static_cast<std::int64_t>(t);
    for (std::int64_t p = 0; p < part_count(*shape); ++p) {
      const PlacedPart part = shape_part(*shape, p);
      const ShapeMesh mesh = fine_mesh(*part.shape);
      EXPECT_EQ(static_cast<std::int64_t>(mesh.triangles.size()), fine_triangles(*part.shape));
      EXPECT_EQ(static_cast<std::int64_t>(mesh.vertices.size()), fine_vertices(*part.shape));
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const HeightCell cell = cell_of(*shape, part.first_triangle + static_cast<std::int32_t>(t));
        EXPECT_EQ(cell.number,
                  2 * (static_cast<std::int64_t>(cell.row) * (f.field.columns - 1) + cell.column) + cell.half);
        const auto expected = twin_of.extract(cell.number);
        ASSERT_FALSE(expected.empty());
        for (std::size_t k = 0; k < 3; ++k) {
          ASSERT_EQ(mesh.vertex(mesh.triangles[t][k]), twin.triangle(expected.mapped())[k]);
        }
      }
    }
    EXPECT_TRUE(twin_of.empty());
    EXPECT_EQ(cell_of(*shape, -1).number, -1);
    EXPECT_EQ(cell_of(*shape, static_cast<std::int32_t>(fine_triangles(*shape))).number, -1);
    EXPECT_EQ(cell_of(*twin.shape, 0).number, -1);
  }
}

TEST(HeightFields, ErrorsOfVerticesAreAccountedFor) {
  shapes::Random random(3);
  for (const double spacing : {0.1, 1.0 / 3, 1e-12, 7e20}) {
    for (const double far : {0.0, 1e-3, 1e6}) {
      Field f = hills(70, 40, 7, 2, spacing);
      for (float& z : f.heights) z += static_cast<float>(random(-1, 1) * spacing);
      f.field.origin = Vector(0.123, -4.56, 7.89) * far * spacing;
      const ShapePtr shape = f.make();
      const Twin twin(f);
      std::map<std::int64_t, std::int64_t> twin_of;
      for (std::size_t t = 0; t < twin.numbers.size(); ++t) twin_of[twin.numbers[t]] = static_cast<std::int64_t>(t);
      EXPECT_GT(fine_error(*shape), 0);
      EXPECT_LT(fine_error(*shape), (2e-6 + 2e-15 * far) * spacing);
      for (std::int64_t p = 0; p < part_count(*shape); ++p) {
        const PlacedPart part = shape_part(*shape, p);
        const ShapeMesh mesh = fine_mesh(*part.shape);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
          const std::int64_t number = cell_of(*shape, part.first_triangle + static_cast<std::int32_t>(t)).number;
          for (std::size_t k = 0; k < 3; ++k) {
            const Vector at = mesh.vertex(mesh.triangles[t][k]), exact = twin.triangle(twin_of.at(number))[k];
            ASSERT_LE((at - exact).norm(), fine_error(*shape) + 4e-16 * exact.norm());
            ASSERT_TRUE(bounds(*shape).contains(exact));
          }
        }
      }
    }
  }
}

TEST(HeightFields, NeighboursShareTheirBorderExactly) {
  Field f = hills(100, 100, 11, 0, 0.1);
  for (float& z : f.heights) z += 0.01F;
  f.field.origin = Vector(0.25, -8, 0.5);
  const ShapePtr shape = f.make();
  std::map<std::pair<std::int32_t, std::int32_t>, std::set<std::array<double, 3>>> places;
  for (std::int64_t p = 0; p < part_count(*shape); ++p) {
    const PlacedPart part = shape_part(*shape, p);
    const ShapeMesh mesh = fine_mesh(*part.shape);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const HeightCell cell = cell_of(*shape, part.first_triangle + static_cast<std::int32_t>(t));
      const auto of = corners(f, cell.column, cell.row, cell.half);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector at = mesh.vertex(mesh.triangles[t][k]);
        places[{of[k][0], of[k][1]}].insert({at.x(), at.y(), at.z()});
      }
    }
  }
  for (const auto& [sample, at] : places) EXPECT_EQ(at.size(), 1u) << sample.first << " " << sample.second;
}

// ---- Twins -----------------------------------------------------------------

/// Bodies of other kinds, of a few cells' size.
std::vector<std::pair<std::string, ShapePtr>> guests(double size) {
  std::vector<std::pair<std::string, ShapePtr>> all;
  const auto scaled_shape = [&](const TriangleMesh& mesh, bool hollow = false) {
    return make_shape(shapes::scaled(mesh, size), {.hollow = hollow});
  };
  all.emplace_back("box", scaled_shape(shapes::cube(0.5)));
  all.emplace_back("sphere", scaled_shape(shapes::sphere(3)));
  all.emplace_back("torus", scaled_shape(shapes::torus(2, 0.5, 20, 10)));
  all.emplace_back("sheet", scaled_shape(sheet(6, 2, 2), true));
  all.emplace_back("triangle and point",
                   scaled_shape(shapes::with_triangle(shapes::tetrahedron(1), {2, 0, 0}, {2, 0, 0}, {2, 0, 0})));
  CageHierarchy caged = sample_shapes(0)[1].hierarchy;
  all.emplace_back("caged", make_shape(caged));
  const CompoundPart parts[] = {{all[0].second}, {all[1].second, shift(2 * size), 0.5}};
  all.emplace_back("compound", make_compound(parts));
  return all;
}

struct Placed {
  Motion field, guest;
};

/// Poses beside the field, some of them on grid lines and on the seams of tiles.
Placed random_place(shapes::Random& random, Field& f) {
  Placed at;
  const double step = static_cast<double>(f.field.spacing_x);
  const bool on_grid = random.integer(3) == 0;
  Vector p;
  const auto along = [&](std::int32_t samples) {
    const double cell = on_grid ? std::min(samples - 1, 32 * random.integer(3)) : random(-4, samples + 4);
    return cell * step;
  };
  p << along(f.field.columns), along(f.field.rows), random(-2.5, 2.5) * step;
  Eigen::Isometry3d start = on_grid ? Eigen::Isometry3d::Identity() : random_pose(random, 0);
  start.translation() = f.field.origin + p;
  at.guest = random.integer(2) == 0 ? Motion::resting(start) : random_motion(random, start, 0.4, 3 * step);
  at.field = Motion::resting(Eigen::Isometry3d::Identity());
  if (random.integer(3) == 0) {
    const Eigen::Isometry3d turn = random_pose(random, 10 * step);
    for (Motion* m : {&at.field, &at.guest}) {
      m->start = turn * m->start;
      m->end = turn * m->end;
    }
  }
  return at;
}

/// No pair of triangles that are nearer than the margin may be missing.
void expect_all_within(double margin, const Twin& twin, const Placed& at, const TriangleMesh& guest,
                       const std::set<std::pair<std::int64_t, std::int32_t>>& pairs) {
  const auto centre_of = [](const RealTriangle& t) { return Point((t[0] + t[1] + t[2]) / 3); };
  const auto reach_of = [](const RealTriangle& t) { return (t[1] - t[0]).norm() + (t[2] - t[0]).norm(); };
  const std::vector<RealTriangle> of_field = at_time(twin.mesh, Vector::Zero(), at.field, 0),
                                  of_guest = at_time(guest, Vector::Zero(), at.guest, 0);
  for (std::size_t i = 0; i < of_field.size(); ++i) {
    for (std::size_t j = 0; j < of_guest.size(); ++j) {
      const RealTriangle &a = of_field[i], &b = of_guest[j];
      if ((centre_of(a) - centre_of(b)).norm() > reach_of(a) + reach_of(b) + margin) continue;
      if (test::triangle_distance(a, b) > margin) continue;
      EXPECT_TRUE(pairs.contains({twin.numbers[i], static_cast<std::int32_t>(j)}));
    }
  }
}

TEST(HeightFields, AnswerAsTheirMeshesDo) {
  shapes::Random random(5);
  int apart = 0, touching = 0, met = 0;
  for (Field& f : fields()) {
    const double step = static_cast<double>(f.field.spacing_x);
    const ShapePtr shape = f.make();
    const Twin twin(f);
    const auto others = guests(step);
    for (int i = 0; i < 80; ++i) {
      const auto& [name, other] = others[static_cast<std::size_t>(i) % others.size()];
      if (name == "caged" && (step < 0.1 || step > 10)) continue;
      const Placed at = random_place(random, f);
      SCOPED_TRACE(name + " " + std::to_string(i) + " of " + std::to_string(f.field.columns));
      const DistanceResult d = encage::distance(*shape, at.field, *other, at.guest),
                           e = encage::distance(*twin.shape, at.field, *other, at.guest);
      // Where surfaces cross, that is proven or not, by chance.
      const double far = 1e-9 * step + 2 * fine_error(*other);
      EXPECT_NEAR(d.upper, e.upper, far);
      EXPECT_NEAR(d.lower, e.lower, far);
      EXPECT_NEAR(encage::distance(*other, at.guest, *shape, at.field).upper, e.upper, far);
      const double limit = random(0.1, 2) * step;
      const DistanceResult below = encage::distance(*shape, at.field, *other, at.guest, {.limit = limit});
      EXPECT_NEAR(below.lower, std::min(limit, e.lower), far);

      const Verdict verdict = separated(*shape, at.field, *other, at.guest, 0.0),
                    expected = separated(*twin.shape, at.field, *other, at.guest, 0.0);
      // Both may answer "maybe" where rounding leaves it open.
      const auto contact = first_contact(*shape, at.field, *other, at.guest),
                 first = first_contact(*twin.shape, at.field, *other, at.guest);
      ASSERT_EQ(contact.has_value(), first.has_value());
      EXPECT_EQ(verdict.separated, expected.separated);
      ++(verdict.separated ? apart : touching);
      if (contact) {
        EXPECT_NEAR(contact->time, first->time, 0x1p-20);
        EXPECT_EQ(contact->overlapping, first->overlapping);
        ++met;
      }
      EXPECT_FALSE(verdict.separated && contact);

      const double margin = random.integer(2) == 0 ? 0 : 0.3 * step;
      std::set<std::pair<std::int64_t, std::int32_t>> pairs;
      for_each_triangle_pair(*shape, at.field, *other, at.guest, margin, [&](TrianglePair pair) {
        EXPECT_TRUE(pairs.emplace(cell_of(*shape, pair.a).number, pair.b).second);
        return true;
      });
      if (name == "box" && at.guest.at_rest())
        expect_all_within(margin, twin, at, shapes::scaled(shapes::cube(0.5), step), pairs);
      std::vector<Vector> hull;
      for (int k = 0; k < 5; ++k) {
        hull.emplace_back(at.guest.start.translation() + step * Vector(random_direction(random)));
      }
      EXPECT_EQ(overlaps(*shape, at.field, hull), overlaps(*twin.shape, at.field, hull));
      const Sphere ball{at.guest.start.translation(), random(0, 2) * step};
      EXPECT_EQ(overlaps(*shape, at.field, ball), overlaps(*twin.shape, at.field, ball));
    }
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(touching, 100);
  EXPECT_GT(met, 100);
}

TEST(HeightFields, WhatTouchesIsNeverSeparated) {
  Field f(65, 65, 1);
  const ShapePtr shape = f.make(), box = make_shape(shapes::cube(0.5));
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  for (const double x : {0.0, 0.5, 31.5, 32.0, 32.25, 63.5, 64.5}) {
    for (const double y : {-0.5, 16.0, 32.0, 32.5, 64.0}) {
      for (const double z : {-0.5, -0.25, 0.0, 0.5}) {
        const Motion at = Motion::resting(shift(x, y, z));
        EXPECT_FALSE(separated(*shape, rest, *box, at).separated);
        EXPECT_FALSE(separated(*box, at, *shape, rest).separated);
        EXPECT_TRUE(first_contact(*shape, rest, *box, at).has_value());
        EXPECT_TRUE(overlaps(*shape, rest, OrientedBox{at.start, {0.5, 0.5, 0.5}}));
      }
      const Motion above = Motion::resting(shift(x, y, 0.5 + 1e-9));
      EXPECT_TRUE(separated(*shape, rest, *box, above).separated);
    }
  }
}

// ---- Rays and points -------------------------------------------------------

TEST(HeightFields, RaysHitWhatTheyHitOfTheMesh) {
  shapes::Random random(9);
  int hits = 0, misses = 0, doubtful = 0;
  for (Field& f : fields()) {
    const double step = static_cast<double>(f.field.spacing_x);
    const ShapePtr shape = f.make();
    const Twin twin(f);
    for (int i = 0; i < 2000; ++i) {
      const Motion at = Motion::resting(i % 3 == 0 ? random_pose(random, 10 * step) : Eigen::Isometry3d::Identity());
      // Every other ray is aimed at a vertex, or at an edge of the grid, mostly on a seam.
      const auto sample = [&](std::int32_t samples) {
        return std::min(samples - 1, random.integer(2) == 0 ? 32 * random.integer(3) : random.integer(samples));
      };
      const std::int32_t c = sample(f.field.columns), r = sample(f.field.rows);
      Vector to = f.field.origin + Vector(random(-1, f.field.columns), random(-1, f.field.rows), random(-2, 2)) * step;
      if (i % 2 == 0 && !std::isnan(f.at(c, r))) {
        to = f.vertex(c, r);
        if (r + 1 < f.field.rows && !std::isnan(f.at(c, r + 1)) && i % 4 == 0) {
          to += random(0, 1) * (f.vertex(c, r + 1) - to);
        }
      }
      Vector from = to + Vector(random(-20, 20), random(-20, 20), random(1, 20)) * step;
      if (i % 5 == 0) from = to + Vector(0, 0, 8 * step);
      const Ray ray{.origin = at.start * from, .direction = at.start.linear() * (to - from) * random(0.3, 2)};
      RayHit room[40], twin_room[40];
      const RayHits all = all_hits(*shape, at, ray, room), expected = all_hits(*twin.shape, at, ray, twin_room);
      const RayResult first = cast_ray(*shape, at, ray), twin_first = cast_ray(*twin.shape, at, ray);
      // A ray that is aimed at an edge may pass it within rounding.
      if (i % 2 == 0 && (first.answer != twin_first.answer || std::abs(first.hit.t - twin_first.hit.t) > 1e-9)) {
        ++doubtful;
        continue;
      }
      ASSERT_EQ(first.answer, twin_first.answer);
      ++(first.answer == RayAnswer::hit ? hits : misses);
      if (first.answer != RayAnswer::hit) continue;
      ASSERT_NEAR(first.hit.t, twin_first.hit.t, 1e-9);
      EXPECT_EQ(all.answer, RayAnswer::hit);
      EXPECT_EQ(room[0].t, first.hit.t);
      EXPECT_EQ(room[0].triangle, first.hit.triangle);
      if (i % 2 == 0) continue;
      EXPECT_EQ(all.count, expected.count);
      EXPECT_EQ(cell_of(*shape, first.hit.triangle).number,
                twin.numbers[static_cast<std::size_t>(twin_first.hit.triangle)]);
      EXPECT_LT((first.hit.normal - twin_first.hit.normal).norm(), 1e-9);
    }
  }
  EXPECT_LT(doubtful, hits / 20);
  EXPECT_GT(hits, 3000);
  EXPECT_GT(misses, 1000);
}

TEST(HeightFields, NoRayPassesBetweenTiles) {
  shapes::Random random(10);
  for (const double spacing : {0.5, 0.1, 1.0 / 3}) {
    Field f = hills(100, 100, 13, 0, spacing);
    f.field.origin = Vector(0.1, 0.7, -0.3);
    const ShapePtr shape = f.make();
    for (int i = 0; i < 3000; ++i) {
      // A point on the seam, or as near to it as a double can be.
      const std::int32_t c = 32 * (1 + random.integer(3)), r = 1 + random.integer(97);
      const Motion at = Motion::resting(i % 2 == 0 ? Eigen::Isometry3d::Identity() : random_pose(random, 5));
      Vector p = f.vertex(c, r);
      if (i % 3 != 0) p += random(0, 1) * (f.vertex(c, r + 1) - p);
      if (i % 7 == 0) p.x() = std::nextafter(p.x(), random(-1, 1) * 1e9);
      const Vector way = Vector(random(-0.4, 0.4), random(-0.4, 0.4), -1);
      const Ray ray{.origin = at.start * Vector(p - 3 * way), .direction = at.start.linear() * way};
      EXPECT_EQ(cast_ray(*shape, at, ray).answer, RayAnswer::hit);
    }
  }
}

TEST(HeightFields, NearestPointsAreThoseOfTheMesh) {
  shapes::Random random(12);
  for (Field& f : fields()) {
    const double step = static_cast<double>(f.field.spacing_x);
    const ShapePtr shape = f.make();
    const Twin twin(f);
    for (int i = 0; i < 400; ++i) {
      const Motion at = Motion::resting(i % 3 == 0 ? random_pose(random, 10 * step) : Eigen::Isometry3d::Identity());
      Vector p =
          f.field.origin + Vector(random(-9, f.field.columns + 9), random(-9, f.field.rows + 9), random(-4, 4)) * step;
      if (i % 4 == 0) p.x() = f.field.origin.x() + 32 * step;
      p = at.start * p;
      const ClosestPoint found = closest_point(*shape, at, p), expected = closest_point(*twin.shape, at, p);
      EXPECT_NEAR(found.upper / step, expected.upper / step, 1e-9);
      EXPECT_NEAR(found.lower / step, expected.lower / step, 1e-9);
      const SignedDistance s = signed_distance(*shape, at, p);
      EXPECT_NE(s.side, PointSide::inside);
      EXPECT_NEAR(s.upper / step, expected.upper / step, 1e-9);
      EXPECT_EQ(contains(*shape, at, p), contains(*twin.shape, at, p));
    }
  }
}

TEST(HeightFields, OfAnySizeAnswerAsTheirMeshesDo) {
  shapes::Random random(14);
  for (const auto& [spacing, height] : {std::pair{1e-30, 1e-30}, std::pair{1e-30, 1e-20}, std::pair{1.0, 1e9},
                                        std::pair{1e30, 1e36}, std::pair{1e35, 1.0}, std::pair{1e-3, 0.0}}) {
    Field f(40, 40, spacing);
    for (float& z : f.heights) z = static_cast<float>(random(-height, height));
    const ShapePtr shape = f.make();
    const Twin twin(f);
    const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
    const double size = spacing + height;
    for (int i = 0; i < 200; ++i) {
      const std::int32_t c = 1 + random.integer(38), r = 1 + random.integer(38);
      Vector above = f.vertex(c, r);
      above.x() += i % 2 == 0 ? 0 : random(0, 0.9) * spacing;
      above.z() = 2 * height + spacing;
      const Ray ray{.origin = above, .direction = {0, 0, -1}};
      const RayResult hit = cast_ray(*shape, rest, ray), expected = cast_ray(*twin.shape, rest, ray);
      ASSERT_EQ(hit.answer, RayAnswer::hit);
      ASSERT_EQ(expected.answer, RayAnswer::hit);
      // Along cliffs the place of a hit is uncertain.
      if (height <= spacing) {
        EXPECT_NEAR(hit.hit.t / size, expected.hit.t / size, 1e-5);
      }
      const ClosestPoint near = closest_point(*shape, rest, above), near_mesh = closest_point(*twin.shape, rest, above);
      EXPECT_LE(near.lower, near_mesh.upper);
      EXPECT_LE(near_mesh.lower, near.upper);
      EXPECT_LE(near.upper - near.lower, 2.1 * fine_error(*shape) + 1e-12 * 40 * size);
    }
  }
}

// ---- Contacts --------------------------------------------------------------

std::vector<ManifoldPoint> contact_points(const Shape& a, const Motion& motion_a, const Shape& b,
                                          const Motion& motion_b, const ManifoldOptions& options,
                                          ManifoldCache& cache) {
  std::vector<ManifoldPoint> points(512);
  const int count = contact_manifold(a, motion_a, b, motion_b, options, cache, points);
  points.resize(static_cast<std::size_t>(count));
  return points;
}

TEST(HeightFieldContacts, SeamsOfAFlatFieldAreNotFelt) {
  for (const CellDiagonal diagonal : {CellDiagonal::rising, CellDiagonal::falling, CellDiagonal::alternating}) {
    Field f(97, 97, 1);
    f.options.diagonal = diagonal;
    const ShapePtr shape = f.make();
    const Twin twin(f);
    const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
    const ManifoldOptions options{.margin = 0.4, .most_points = 512, .most_per_patch = 512};
    for (const ShapePtr& guest : {make_shape(shapes::cube(0.7)), make_shape(shapes::sphere(2)),
                                  make_shape(shapes::torus(2, 0.5, 20, 10)), make_shape(shapes::cube(5))}) {
      const double lowest = bounds(*guest).min().z();
      const bool flat = fine_triangles(*guest) == 12;
      for (const double height : {0.2, 1e-3, 0.0, -1e-3, -0.1}) {
        for (const double y : {20.3, 32.0, 31.9}) {
          ManifoldCache cache, other, twin_cache, twin_turned;
          for (double x = 30.1; x < 34; x += 0.23) {
            const Motion at = Motion::resting(shift(x, y, height - lowest));
            const auto points = contact_points(*guest, at, *shape, rest, options, cache),
                       turned = contact_points(*shape, rest, *guest, at, options, other),
                       expected = contact_points(*guest, at, *twin.shape, rest, options, twin_cache),
                       expected_turned = contact_points(*twin.shape, rest, *guest, at, options, twin_turned);
            const auto least = [](const std::vector<ManifoldPoint>& all, double sign) {
              double up = 1, apart = 1;
              for (const ManifoldPoint& p : all) {
                up = std::min(up, sign * p.normal.z());
                apart = std::min(apart, p.separation);
              }
              return std::pair(up, apart);
            };
            ASSERT_FALSE(points.empty());
            const auto [up, apart] = least(points, 1);
            // Faces of round bodies lean; those of a cube do not.
            ASSERT_GE(up, (flat ? 1 : least(expected, 1).first) - 1e-6) << x << " " << y << " " << height;
            ASSERT_GE(least(turned, -1).first, (flat ? 1 : least(expected_turned, -1).first) - 1e-6) << x << " " << y;
            EXPECT_NEAR(apart, least(expected, 1).second, 1e-9);
          }
        }
      }
    }
  }
}

TEST(HeightFieldContacts, RoundBodiesRollOverSeams) {
  Field f(97, 97, 1);
  const ShapePtr shape = f.make();
  TriangleMesh point;
  point.vertices = Vertices::Zero(1, 3);
  point.triangles.setZero(1, 3);
  const ShapePtr ball = make_shape(point);
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  ManifoldCache cache;
  for (double x = 30.1; x < 34; x += 0.0625) {
    for (const double y : {20.3, 32.0, 63.99}) {
      const ManifoldOptions options{.margin = 0.1, .radius_a = 0.5};
      const auto points = contact_points(*ball, Motion::resting(shift(x, y, 0.45)), *shape, rest, options, cache);
      ASSERT_FALSE(points.empty()) << x << " " << y;
      for (const ManifoldPoint& p : points) {
        EXPECT_GT(p.normal.z(), 1 - 1e-12);
        EXPECT_NEAR(p.separation, -0.05, 1e-12);
      }
    }
  }
}

TEST(HeightFieldContacts, BodiesThatHaveSunkInKeepTheirSide) {
  Field f(97, 97, 1);
  const ShapePtr shape = f.make(), cube = make_shape(shapes::cube(0.25));
  const Twin twin(f);
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  const ManifoldOptions options{.margin = 0.15};
  for (const double y : {20.3, 32.0, 63.9}) {
    ManifoldCache cache, twin_cache;
    for (int i = 0; i < 100; ++i) {
      const double height = std::max(-0.1, 0.005 - 0.005 * i), x = 30.5 + 0.03 * i;
      const Motion at = Motion::resting(shift(x, y, 0.25 + height));
      const auto points = contact_points(*cube, at, *shape, rest, options, cache),
                 expected = contact_points(*cube, at, *twin.shape, rest, options, twin_cache);
      const auto upright = [](const std::vector<ManifoldPoint>& all) {
        return std::count_if(all.begin(), all.end(), [](const ManifoldPoint& p) { return p.normal.z() > 1 - 1e-9; });
      };
      ASSERT_GE(upright(points), 4) << x << " " << y;
      ASSERT_EQ(points.size(), expected.size()) << x << " " << y;
      ASSERT_EQ(upright(points), upright(expected)) << x << " " << y;
      for (const ManifoldPoint& p : points) {
        if (p.normal.z() > 1 - 1e-9) {
          ASSERT_NEAR(p.separation, height, 1e-7) << x << " " << y;
        }
      }
    }
  }
}

TEST(HeightFieldContacts, AreThoseOfTheMesh) {
  shapes::Random random(21);
  int compared = 0, missing = 0;
  for (std::uint32_t seed = 30; seed < 36; ++seed) {
    Field f = hills(70, 70, seed, seed % 2 == 0 ? 0 : 5);
    const ShapePtr shape = f.make();
    const Twin twin(f);
    for (int i = 0; i < 60; ++i) {
      const ShapePtr guest = i % 3 == 0   ? make_shape(shapes::cube(0.6))
                             : i % 3 == 1 ? make_shape(shapes::sphere(2))
                                          : make_shape(sheet(3, 1, 0.8), {.hollow = true});
      const std::int32_t c = 32 * (1 + random.integer(2)), r = 1 + random.integer(68);
      Eigen::Isometry3d pose = random_pose(random, 0);
      const double ground = std::isnan(f.at(c, r)) ? f.field.origin.z() : f.vertex(c, r).z();
      pose.translation() = Vector(f.field.origin.x() + 0.5 * c + random(-0.5, 0.5),
                                  f.field.origin.y() + 0.5 * r + random(-0.5, 0.5), ground + random(0.4, 1.3));
      const Motion at = Motion::resting(pose), rest = Motion::resting(Eigen::Isometry3d::Identity());
      const ManifoldOptions options{.margin = 0.05, .most_points = 512, .most_per_patch = 512};
      ManifoldCache cache, twin_cache;
      const auto points = contact_points(*guest, at, *shape, rest, options, cache),
                 expected = contact_points(*guest, at, *twin.shape, rest, options, twin_cache);
      EXPECT_EQ(points.empty(), expected.empty());
      for (const ManifoldPoint& p : expected) {
        ++compared;
        missing += std::none_of(points.begin(), points.end(), [&](const ManifoldPoint& q) {
          return (p.point_a - q.point_a).norm() < 1e-9 && (p.point_b - q.point_b).norm() < 1e-9 &&
                 (p.normal - q.normal).norm() < 1e-6 && std::abs(p.separation - q.separation) < 1e-9;
        });
      }
    }
  }
  EXPECT_GT(compared, 500);
  // The order of features decides between some that touch alike.
  EXPECT_LT(missing, compared / 20) << missing << " of " << compared;
}

// ---- Memory ----------------------------------------------------------------

TEST(HeightFieldMemory, TakesFewBytesASample) {
  const Field f = [] {
    Field field(513, 513, 1);
    for (std::int32_t j = 0; j < 513; ++j) {
      for (std::int32_t i = 0; i < 513; ++i) field.at(i, j) = static_cast<float>(std::sin(0.1 * i) + std::cos(0.1 * j));
    }
    return field;
  }();
  Field copy = f;
  const ShapePtr shape = copy.make();
  const std::int64_t at_rest = memory_use(*shape).owned;
  EXPECT_LT(at_rest, std::int64_t{8} * 513 * 513);
  EXPECT_GT(at_rest, std::int64_t{4} * 513 * 513);
  EXPECT_EQ(memory_use(*shape).mapped, 0);
  // A query near one tile makes one mesh.
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  const Ray ray{.origin = {100.5, 100.5, 10}, .direction = {0, 0, -1}};
  EXPECT_EQ(cast_ray(*shape, rest, ray).answer, RayAnswer::hit);
  EXPECT_GT(memory_use(*shape).owned, at_rest);
  EXPECT_LT(memory_use(*shape).owned, at_rest + 300'000);
}

/// Answers of every kind, as numbers.
std::vector<double> answers(const Shape& field, const Shape& guest, const Motion& at) {
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  std::vector<double> all;
  const DistanceResult d = encage::distance(field, rest, guest, at, {.limit = 3});
  all.insert(all.end(), {d.lower, d.upper, double(d.triangle_a), double(d.triangle_b)});
  const Verdict verdict = separated(field, rest, guest, at, 0.0);
  all.insert(all.end(), {double(verdict.separated), double(verdict.stage)});
  if (const auto contact = first_contact(field, rest, guest, at)) {
    all.push_back(contact->time);
    for (const std::int32_t v : contact->vertices) all.push_back(v);
  }
  const Vector p = at.start.translation();
  const RayResult hit = cast_ray(field, rest, {.origin = p, .direction = {0.3, 0.4, -0.2}});
  all.insert(all.end(), {double(hit.answer), hit.hit.t, double(hit.hit.triangle)});
  const ClosestPoint closest = closest_point(field, rest, p);
  all.insert(all.end(), {closest.lower, closest.upper, double(closest.triangle)});
  ManifoldCache cache;
  for (const ManifoldPoint& q : contact_points(guest, at, field, rest, {.margin = 0.05}, cache)) {
    all.insert(all.end(), {q.point_a.x(), q.point_b.y(), q.normal.z(), q.separation, double(q.feature)});
  }
  return all;
}

struct Asked {
  Field plenty = hills(200, 200, 40), few = hills(200, 200, 40);
  ShapePtr field, tight, guest = make_shape(shapes::sphere(2));
  std::vector<Motion> motions;

  explicit Asked(int count) {
    few.options.budget_bytes = 1 << 19;
    field = plenty.make();
    tight = few.make();
    shapes::Random random(41);
    for (int i = 0; i < count; ++i) {
      Eigen::Isometry3d start = random_pose(random, 0);
      start.translation() = plenty.field.origin + Vector(random(0, 100), random(0, 100), random(-1, 2));
      motions.push_back(random_motion(random, start, 0.3, 3));
    }
  }
};

TEST(HeightFieldMemory, AnswersDoNotDependOnTheBudget) {
  const Asked asked(300);
  const std::int64_t at_rest = memory_use(*asked.tight).owned;
  for (const Motion& motion : asked.motions) {
    ASSERT_EQ(answers(*asked.tight, *asked.guest, motion), answers(*asked.field, *asked.guest, motion));
    ASSERT_LE(memory_use(*asked.tight).owned, at_rest + asked.few.options.budget_bytes);
  }
  EXPECT_GT(memory_use(*asked.field).owned, at_rest + asked.few.options.budget_bytes);
}

TEST(HeightFieldMemory, AnswersAreTheSameForManyThreads) {
  const Asked asked(60);
  std::vector<std::vector<double>> expected;
  for (const Motion& motion : asked.motions) expected.push_back(answers(*asked.field, *asked.guest, motion));
  const std::int64_t at_rest = memory_use(*asked.tight).owned;
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        for (std::size_t i = 0; i < asked.motions.size(); ++i) {
          const std::size_t n = (17 * t + i) % asked.motions.size();
          EXPECT_EQ(answers(*asked.tight, *asked.guest, asked.motions[n]), expected[n]);
          EXPECT_GE(memory_use(*asked.tight).owned, at_rest);
        }
      });
    }
  }
  EXPECT_LE(memory_use(*asked.tight).owned, at_rest + asked.few.options.budget_bytes);
}

// ---- Bodies ----------------------------------------------------------------

TEST(HeightFields, ArePartsOfCompounds) {
  Field f = hills(70, 70, 50, 4);
  const ShapePtr field = f.make(), box = make_shape(shapes::cube(0.5));
  const Twin twin(f);
  shapes::Random random(51);
  const Eigen::Isometry3d pose = random_pose(random, 5);
  const CompoundPart parts[] = {{box, shift(100)}, {field, pose, 1.5}},
                     twins[] = {{box, shift(100)}, {twin.shape, pose, 1.5}};
  const ShapePtr whole = make_compound(parts), other = make_compound(twins);
  EXPECT_EQ(cell_of(*whole, 3).number, -1);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const Motion at = Motion::resting(random_pose(random, 20), 0.7);
    const Vector to =
        at.start * Vector(0.7 * (pose * Vector(1.5 * (f.field.origin + Vector(random(0, 35), random(0, 35), 0)))));
    const Ray ray{.origin = Vector(1, 2, 3), .direction = to - Vector(1, 2, 3)};
    const RayResult found = cast_ray(*whole, at, ray), expected = cast_ray(*other, at, ray);
    ASSERT_EQ(found.answer, expected.answer);
    if (found.answer != RayAnswer::hit) continue;
    ++hits;
    ASSERT_NEAR(found.hit.t, expected.hit.t, 1e-9);
    EXPECT_EQ(cell_of(*whole, found.hit.triangle).number,
              twin.numbers[static_cast<std::size_t>(part_triangle(*other, expected.hit.triangle).triangle)]);
  }
  EXPECT_GT(hits, 200);
}

TEST(HeightFields, AreStaticBodiesOfWorlds) {
  Field f = hills(100, 100, 60);
  const ShapePtr shape = f.make();
  const Twin twin(f);
  shapes::Random random(61);
  World world, twin_world;
  std::vector<std::pair<BodyId, BodyId>> bodies;
  for (const auto& [w, ground] : {std::pair{&world, shape}, std::pair{&twin_world, twin.shape}}) {
    w->add_body(w->add_shape(ground), Eigen::Isometry3d::Identity(), {.kind = BodyKind::static_});
  }
  const ShapePtr ball = make_shape(shapes::sphere(2));
  const ShapeId of = world.add_shape(ball), of_twin = twin_world.add_shape(ball);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Isometry3d pose =
        shift(f.field.origin.x() + random(0, 50), f.field.origin.y() + random(0, 50), 1 + random(-2, 3));
    world.add_body(of, pose);
    twin_world.add_body(of_twin, pose);
  }
  const auto candidates = [](World& w) {
    std::set<std::pair<BodyId, BodyId>> pairs;
    w.find_candidates({}, [&](const CandidatePair& pair) { pairs.emplace(pair.a, pair.b); });
    return pairs;
  };
  const auto found = candidates(world);
  EXPECT_EQ(found, candidates(twin_world));
  EXPECT_GT(found.size(), 20u);
  // Contacts of each pair: the deepest point, and the time of first contact.
  const auto contacts_of = [](World& w) {
    WorldContacts contacts;
    std::map<std::pair<BodyId, BodyId>, std::pair<double, double>> deepest;
    contacts.find(w, {.margin = 0.05, .first_contacts = true, .most_points = 512, .most_per_patch = 512},
                  [&](const ContactPair& pair) {
                    auto& [depth, time] = deepest[{pair.a, pair.b}];
                    depth = 1;
                    time = pair.first ? pair.first->time : 1;
                    for (const ManifoldPoint& p : pair.points) depth = std::min(depth, p.separation);
                  });
    return deepest;
  };
  const auto of_tiles = contacts_of(world), of_mesh = contacts_of(twin_world);
  ASSERT_EQ(of_tiles.size(), of_mesh.size());
  EXPECT_GT(of_tiles.size(), 20u);
  for (auto one = of_tiles.begin(), other = of_mesh.begin(); one != of_tiles.end(); ++one, ++other) {
    EXPECT_EQ(one->first, other->first);
    EXPECT_NEAR(one->second.first, other->second.first, 1e-6);
    EXPECT_NEAR(one->second.second, other->second.second, 0x1p-20);
  }
}

// ---- Errors ----------------------------------------------------------------

TEST(HeightFields, RefuseByName) {
  const auto error = [](const auto& change) {
    Field f(3, 4, 1);
    f.field.heights = f.heights;
    change(f);
    return error_of([&] { make_height_field(f.field, f.options); });
  };
  EXPECT_EQ(error([](Field& f) { f.field.columns = 1; }), "height field: columns is 1, a cell needs 2");
  EXPECT_EQ(error([](Field& f) { f.field.rows = -7; }), "height field: rows is -7, a cell needs 2");
  EXPECT_EQ(error([](Field& f) { f.field.rows = 5; }), "height field: heights has 12 numbers, columns * rows is 15");
  EXPECT_EQ(error([](Field& f) { f.field.spacing_x = 0; }), "height field: spacing_x is 0, not positive and finite");
  EXPECT_EQ(error([](Field& f) { f.field.spacing_y = -1; }), "height field: spacing_y is -1, not positive and finite");
  EXPECT_EQ(error([](Field& f) { f.field.spacing_y = hole; }),
            "height field: spacing_y is nan, not positive and finite");
  EXPECT_EQ(error([](Field& f) { f.field.spacing_x = std::numeric_limits<float>::infinity(); }),
            "height field: spacing_x is inf, not positive and finite");
  EXPECT_EQ(error([](Field& f) { f.field.spacing_x = 1e37F; }).rfind("height field: it reaches 2.99", 0), 0u);
  EXPECT_EQ(error([](Field& f) { f.heights[7] = -std::numeric_limits<float>::infinity(); }),
            "height field: the height in column 1 and row 2 is -inf, not finite: holes are NaN");
  EXPECT_EQ(
      error([](Field& f) { f.heights[7] = 3e38F; }).rfind("height field: the height in column 1 and row 2 is ", 0), 0u);
  EXPECT_EQ(error([](Field& f) { f.field.origin.x() = hole; }), "height field: origin is not finite");
  EXPECT_EQ(error([](Field& f) { f.field.origin.z() = 1e38; }),
            "height field: origin.z is 1e+38, beyond 1e37: choose a larger unit");
  EXPECT_EQ(error([](Field& f) { std::fill(f.heights.begin(), f.heights.end(), hole); }),
            "height field: every triangle has a hole (NaN) as a corner");
  EXPECT_EQ(error([](Field& f) {
              f.options.budget_bytes = 100;
            }).rfind("height field: budget_bytes is 100, two tiles need ", 0),
            0u);
  const ShapePtr tile = [] {
    Field f(3, 4, 1);
    return f.make();
  }();
  EXPECT_EQ(error_of([&] { refit_shape(*tile, Vertices()); }), "refit: a compound; refit its parts and make it anew");
}

}  // namespace
}  // namespace encage::test
