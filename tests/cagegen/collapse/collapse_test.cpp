// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/collapse.h"

#include "cagegen/collapse/starts.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace encage::makers {
namespace {

constexpr double collapse_clearance = 1e-5;

struct Outcome {
  bool reached = false;
  TriangleMesh cage;
  Certificate certificate;
};

CageEditor editor_around(const Obstacle& obstacle, const TriangleMesh& solid, double quadric_weight = 10) {
  EditorOptions options;
  options.clearance = options.self_clearance = collapse_clearance;
  options.quadric_weight = quadric_weight;
  const auto start = offset_start(obstacle, solid, 1e-3, false, collapse_clearance);
  EXPECT_TRUE(start);
  return CageEditor(obstacle, start.value_or(solid), options);
}

Outcome run(const TriangleMesh& solid, std::int64_t faces) {
  const Obstacle obstacle(solid);
  CageEditor editor = editor_around(obstacle, solid);
  CollapseLimits limits;
  limits.faces = faces;
  Outcome result;
  result.reached = collapse_edges(editor, limits);
  const double before = signed_volume(editor.extract());
  const double gained = tighten(editor);
  EXPECT_GE(gained, 0);
  result.cage = editor.extract();
  EXPECT_NEAR(before - signed_volume(result.cage), gained, 1e-9);
  const CertifyResult proof = certify(solid, Solid::closed, result.cage);
  EXPECT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, 0.999 * collapse_clearance);
  result.certificate = proof.certificate;
  return result;
}

TEST(CollapseEdges, Sphere) {
  for (const std::int64_t faces : {400, 60, 12}) {
    const Outcome result = run(shapes::sphere(4), faces);
    EXPECT_TRUE(result.reached);
    EXPECT_LE(result.cage.triangles.rows(), faces);
    EXPECT_GE(result.cage.triangles.rows(), faces - 1);
    EXPECT_EQ(result.certificate.genus, 0);
    EXPECT_LT(result.certificate.volume, 4.2 * (1 + 24.0 / static_cast<double>(faces)));
  }
}

TEST(CollapseEdges, TorusKeepsItsHole) {
  const Outcome result = run(shapes::torus(1, 0.4, 40, 20), 60);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.certificate.genus, 1);
  const Outcome least = run(shapes::torus(1, 0.4, 40, 20), 4);
  EXPECT_FALSE(least.reached) << "a torus of 4 triangles";
  EXPECT_EQ(least.certificate.genus, 1);
}

TEST(CollapseEdges, TinyComponentsAreNotLost) {
  TriangleMesh solid = shapes::joined(shapes::sphere(3), shapes::moved(shapes::sphere(3), {4, 1, 0}));
  solid = shapes::joined(solid, shapes::moved(shapes::scaled(shapes::sphere(1), 0.02), {1.05, 0.2, 0.9}));
  const Outcome result = run(solid, 40);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.certificate.components, 3);
}

TEST(CollapseEdges, IsDeterministic) {
  const TriangleMesh solid = shapes::torus(1, 0.3, 32, 16);
  const Outcome one = run(solid, 80);
  const Outcome two = run(solid, 80);
  EXPECT_EQ(one.cage.vertices, two.cage.vertices);
  EXPECT_EQ(one.cage.triangles, two.cage.triangles);
}

TEST(CollapseEdges, NothingToDo) {
  const TriangleMesh solid = shapes::sphere(2);
  const Obstacle obstacle(solid);
  CageEditor editor = editor_around(obstacle, solid);
  CollapseLimits limits;
  limits.faces = 128;
  const TriangleMesh before = editor.extract();
  EXPECT_TRUE(collapse_edges(editor, limits));
  EXPECT_EQ(editor.extract().vertices, before.vertices);
}

TEST(CollapseEdges, Limits) {
  const TriangleMesh solid = shapes::sphere(4);
  const Obstacle obstacle(solid);
  CollapseLimits limits;
  limits.faces = 20;
  {
    CageEditor editor = editor_around(obstacle, solid);
    limits.work = 1000;
    EXPECT_FALSE(collapse_edges(editor, limits)) << "work";
    EXPECT_GT(editor.face_count(), 20);
    EXPECT_TRUE(certify(solid, Solid::closed, editor.extract()).holds);
  }
  {
    CageEditor editor = editor_around(obstacle, solid);
    limits.work = 0;
    limits.added_volume = 1e-3;
    EXPECT_FALSE(collapse_edges(editor, limits)) << "volume";
    EXPECT_GT(editor.face_count(), 20);
    EXPECT_TRUE(certify(solid, Solid::closed, editor.extract()).holds);
  }
}

TEST(CollapseEdges, Progress) {
  const TriangleMesh solid = shapes::sphere(4);
  const Obstacle obstacle(solid);
  std::vector<double> seen;
  CollapseLimits limits;
  limits.faces = 50;
  limits.progress = [&](double fraction) { seen.push_back(fraction); };
  CageEditor editor = editor_around(obstacle, solid);
  EXPECT_TRUE(collapse_edges(editor, limits));
  EXPECT_GT(seen.size(), 5u);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_GE(seen.front(), 0);
  EXPECT_LE(seen.back(), 1);
  limits.progress = [](double) { throw std::runtime_error("stop"); };
  CageEditor other = editor_around(obstacle, solid);
  EXPECT_THROW(collapse_edges(other, limits), std::runtime_error);
  EXPECT_TRUE(certify(solid, Solid::closed, other.extract()).holds) << "valid after every edit";
}

}  // namespace
}  // namespace encage::makers
