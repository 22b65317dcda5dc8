// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/cage_editor.h"

#include "cagegen/collapse/starts.h"
#include "src/mesh/rounding.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace encage::makers {
namespace {

using shapes::Random;

constexpr double test_clearance = 1e-4;

EditorOptions options(double quadric_weight) {
  EditorOptions result;
  result.clearance = result.self_clearance = test_clearance;
  result.quadric_weight = quadric_weight;
  return result;
}

TriangleMesh around(const Obstacle& obstacle, const TriangleMesh& mesh) {
  const auto cage = offset_start(obstacle, mesh, 0.01, false, test_clearance);
  EXPECT_TRUE(cage);
  return cage.value_or(mesh);
}

void expect_valid(const TriangleMesh& inner, const TriangleMesh& cage) {
  const CertifyResult proof = certify(inner, Solid::closed, cage);
  ASSERT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, test_clearance * (1 - 1e-6));
  EXPECT_EQ(cage.vertices, shapes::rounded(cage).vertices);
}

std::vector<TriangleMesh> solids() {
  return {shapes::sphere(3), shapes::torus(1, 0.4, 24, 12),
          shapes::joined(shapes::sphere(2), shapes::scaled(shapes::moved(shapes::cube(0.5), {4, 0, 0}), 0.5))};
}

/// What merging or moving the vertices `from` into p costs: the volume between the old triangles at them and the new
/// ones, and the area-weighted squares of p's distances from the old planes.
double quadric_error(const CageEditor& cage, const std::vector<std::int32_t>& from, const Point& p, double weight) {
  const TriangleMesh mesh = cage.extract();
  std::vector<std::int32_t> number;  // of the extracted vertices, in the editor
  for (std::int32_t v = 0; v < cage.vertex_capacity(); ++v) {
    if (cage.alive(v)) number.push_back(v);
  }
  double area = 0;
  double error = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    bool old = false;
    for (int k = 0; k < 3; ++k) old = old || std::count(from.begin(), from.end(), number[mesh.triangles(t, k)]) > 0;
    if (!old) continue;
    const Corners c = shapes::corners(mesh, t);
    const Point cross = (c[1] - c[0]).cross(c[2] - c[0]);
    const double distance = cross.normalized().dot(p - c[0]);
    area += cross.norm() / 2;
    error += cross.norm() / 2 * distance * distance;
  }
  return weight / std::sqrt(area) * error;
}

TEST(CageEditor, ExtractsWhatItWasGiven) {
  const TriangleMesh mesh = shapes::sphere(2);
  const Obstacle obstacle(mesh);
  const TriangleMesh cage = around(obstacle, mesh);
  const CageEditor editor(obstacle, cage, options(1));
  EXPECT_EQ(editor.face_count(), cage.triangles.rows());
  EXPECT_EQ(editor.extract().vertices, cage.vertices);
  EXPECT_EQ(editor.extract().triangles, cage.triangles);
  std::vector<std::int32_t> neighbours;
  editor.neighbours(0, neighbours);
  EXPECT_EQ(neighbours.size(), 4u) << "a corner of the octahedron";
}

TEST(CageEditor, RandomEditsKeepTheCageValid) {
  Random random(61);
  for (const TriangleMesh& solid : solids()) {
    const Obstacle obstacle(solid);
    const double weight = random(0.5, 10);
    CageEditor editor(obstacle, around(obstacle, solid), options(weight));
    const std::int64_t first = editor.face_count();
    int merged = 0;
    int moved = 0;
    std::vector<std::int32_t> neighbours;
    for (int i = 0; i < 1500; ++i) {
      const std::int32_t u = random.integer(editor.vertex_capacity());
      if (!editor.alive(u)) continue;
      const double volume = signed_volume(editor.extract());
      const std::int64_t faces = editor.face_count();
      if (i % 3 == 0) {
        const auto plan = editor.plan_tightening(u, 0.1);
        if (!plan) continue;
        EXPECT_LT(plan->cost, 0);
        EXPECT_LT((plan->position - editor.position(u)).norm(), 1);
        editor.apply_move(u, plan->position);
        EXPECT_EQ(editor.position(u), plan->position);
        EXPECT_EQ(editor.face_count(), faces);
        EXPECT_NEAR(signed_volume(editor.extract()) - volume, plan->cost, 1e-9);
        ++moved;
      } else {
        editor.neighbours(u, neighbours);
        const std::int32_t v = neighbours[random.integer(static_cast<int>(neighbours.size()))];
        const auto plan = editor.plan_collapse(u, v);
        if (!plan) continue;
        const double error = quadric_error(editor, {u, v}, plan->position, weight);
        editor.apply_collapse(u, v, plan->position);
        EXPECT_FALSE(editor.alive(v));
        EXPECT_EQ(editor.face_count(), faces - 2);
        EXPECT_NEAR(signed_volume(editor.extract()) - volume, plan->cost - error, 1e-9);
        ++merged;
      }
      if (i % 50 == 0) expect_valid(solid, editor.extract());
    }
    EXPECT_GT(merged, 40);
    EXPECT_GT(moved, 20);
    EXPECT_EQ(editor.face_count(), first - 2 * merged);
    expect_valid(solid, editor.extract());
  }
}

TEST(CageEditor, ATetrahedronCannotLoseAVertex) {
  const TriangleMesh inner = shapes::scaled(shapes::tetrahedron(1), 0.1);
  const Obstacle obstacle(inner);
  CageEditor editor(obstacle, shapes::tetrahedron(4, {-1, -1, -1}), options(1));
  for (std::int32_t u = 0; u < 4; ++u) {
    for (std::int32_t v = 0; v < 4; ++v) {
      EXPECT_TRUE(u == v || !editor.plan_collapse(u, v));
    }
  }
}

TEST(CageEditor, LinkCondition) {
  // Merging across the waist of a double pyramid over a triangle would fold it flat.
  const TriangleMesh cage = shapes::mesh({{2, 0, 0}, {-1, 2, 0}, {-1, -2, 0}, {0, 0, 2}, {0, 0, -2}},
                                         {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {1, 0, 4}, {2, 1, 4}, {0, 2, 4}});
  ASSERT_GT(signed_volume(cage), 0);
  const Obstacle obstacle(shapes::scaled(shapes::tetrahedron(1), 0.1));
  CageEditor editor(obstacle, cage, options(1));
  EXPECT_FALSE(editor.plan_collapse(0, 1));
  EXPECT_TRUE(std::isinf(editor.estimate_collapse(0, 1)));
}

TEST(CageEditor, NeverSweepsPastAComponent) {
  // A cage component around a tiny tetrahedron: no planned edit may leave it outside, whatever is between its cage and
  // where the vertices go.
  const TriangleMesh inner = shapes::joined(shapes::sphere(2), shapes::tetrahedron(1e-3, {3, 3, 3}));
  const Obstacle obstacle(inner);
  const TriangleMesh cage =
      shapes::joined(shapes::rounded(shapes::scaled(shapes::sphere(2), 1.2)),
                     shapes::rounded(shapes::moved(shapes::scaled(shapes::sphere(1), 0.25), {3, 3, 3})));
  CageEditor editor(obstacle, cage, options(1));
  Random random(62);
  for (int i = 0; i < 600; ++i) {
    const std::int32_t u = random.integer(editor.vertex_capacity());
    if (!editor.alive(u)) continue;
    std::vector<std::int32_t> neighbours;
    editor.neighbours(u, neighbours);
    const std::int32_t v = neighbours[random.integer(static_cast<int>(neighbours.size()))];
    if (i % 2) {
      if (const auto plan = editor.plan_tightening(u, 1)) editor.apply_move(u, plan->position);
    } else if (const auto plan = editor.plan_collapse(u, v)) {
      editor.apply_collapse(u, v, plan->position);
    }
    if (i % 20 == 0) expect_valid(inner, editor.extract());
  }
  expect_valid(inner, editor.extract());
}

TEST(RoundToFloat, EveryLane) {
  const Point p(0.1, 1.0 / 3, 1e-20 / 7);
  const Point rounded = round_to_float(p);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(rounded[k], static_cast<double>(static_cast<float>(p[k])));
  EXPECT_NE(rounded, p);
}

TEST(CageEditor, SplitsMoveTheNewVertexInward) {
  for (const TriangleMesh& mesh : solids()) {
    const Obstacle obstacle(mesh);
    const auto loose = offset_start(obstacle, mesh, 0.1, false, test_clearance);
    ASSERT_TRUE(loose);
    CageEditor editor(obstacle, *loose, options(1));
    double volume = signed_volume(*loose);
    std::vector<std::int32_t> neighbours;
    int splits = 0;
    // More than there are spare triangles, so that the tree is built anew in between.
    for (std::int32_t u = 0; u < editor.vertex_capacity() && splits < 100; ++u) {
      editor.neighbours(u, neighbours);
      const std::int32_t v = neighbours.front();
      const auto plan = editor.plan_split(u, v, 0.05);
      if (!plan) continue;
      const std::int64_t faces = editor.face_count();
      const std::int32_t p = editor.apply_split(u, v, plan->position);
      ++splits;
      EXPECT_EQ(editor.face_count(), faces + 2);
      EXPECT_EQ(editor.position(p), plan->position);
      editor.neighbours(p, neighbours);
      EXPECT_EQ(neighbours.size(), 4u);
      const double after = signed_volume(editor.extract());
      EXPECT_LT(plan->cost, 0);
      EXPECT_NEAR(after - volume, plan->cost, 1e-9);
      volume = after;
    }
    EXPECT_GT(splits, 20);
    expect_valid(mesh, editor.extract());
  }
}

TEST(CageEditor, SplitsOnlyEdges) {
  const TriangleMesh mesh = shapes::sphere(2);
  const Obstacle obstacle(mesh);
  CageEditor editor(obstacle, around(obstacle, mesh), options(1));
  std::vector<std::int32_t> neighbours;
  editor.neighbours(0, neighbours);
  std::int32_t other = 1;
  while (std::count(neighbours.begin(), neighbours.end(), other) > 0) ++other;
  EXPECT_FALSE(editor.plan_split(0, other, 0.1));
}

}  // namespace
}  // namespace encage::makers
