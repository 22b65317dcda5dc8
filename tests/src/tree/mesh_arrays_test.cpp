// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/tree/mesh_arrays.h"

#include "oracles/meshes.h"
#include "tests/src/asset/forge.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace encage {
namespace {

TriangleMesh rounded(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

/// Triangles over few vertices: edges with many triangles, repeated vertices, repeated triangles, unused vertices.
TriangleMesh tangle(int vertices, int triangles, std::uint32_t seed) {
  shapes::Random random(seed);
  TriangleMesh mesh;
  mesh.vertices.resize(vertices, 3);
  mesh.triangles.resize(triangles, 3);
  for (int v = 0; v < vertices; ++v) mesh.vertices.row(v) = random.point(1).transpose();
  for (int t = 0; t < triangles; ++t) {
    for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = random.integer(vertices);
  }
  return rounded(mesh);
}

std::vector<TriangleMesh> meshes() {
  std::vector<TriangleMesh> all = {
      shapes::cube(1),
      rounded(shapes::torus(1, 0.3, 9, 5)),
      shapes::joined(shapes::cube(1), shapes::tetrahedron(0.5, {4, 0, 0})),
      shapes::with_triangle(shapes::cube(1), {3, 0, 0}, {4, 0, 0}, {3, 1, 0}),
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}),
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}),
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 1}, {2, 2, 2}}),
      shapes::mesh({{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-9, 0, 0}}, {{1, 2, 3}}),
  };
  for (std::uint32_t seed = 1; seed < 60; ++seed) {
    all.push_back(tangle(4 + static_cast<int>(seed % 30), 1 + static_cast<int>(seed * 7 % 40), seed));
  }
  return all;
}

TEST(MeshArrays, FeaturesBelongToTheFirstTriangleThatHasThem) {
  for (const TriangleMesh& mesh : meshes()) {
    const MeshArrays arrays = make_mesh_arrays(mesh, "m");
    ASSERT_EQ(std::ssize(arrays.owned), mesh.triangles.rows());
    std::set<std::int32_t> vertices;
    std::set<std::pair<std::int32_t, std::int32_t>> edges;
    for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
      unsigned expected = 0;
      for (int k = 0; k < 3; ++k) {
        const std::int32_t v = mesh.triangles(t, k), w = mesh.triangles(t, (k + 1) % 3);
        if (vertices.insert(v).second) expected |= 1U << k;
        if (edges.insert(std::minmax(v, w)).second) expected |= 8U << k;
      }
      EXPECT_EQ(arrays.owned[t], expected) << t;
    }
  }
}

TEST(MeshArrays, PartsAreComponentsWithTheirExtremes) {
  int open = 0, closed = 0;
  for (const TriangleMesh& mesh : meshes()) {
    const MeshArrays arrays = make_mesh_arrays(mesh, "m");
    std::vector<std::int32_t> label;
    ASSERT_EQ(std::ssize(arrays.parts), triangle_components(mesh, label));
    for (std::size_t p = 0; p < arrays.parts.size(); ++p) {
      const MeshPart& part = arrays.parts[p];
      // The part alone, with the same vertices.
      TriangleMesh alone = mesh;
      std::int64_t count = 0;
      for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
        if (label[t] == static_cast<std::int32_t>(p)) alone.triangles.row(count++) = mesh.triangles.row(t);
      }
      alone.triangles.conservativeResize(count, 3);
      EXPECT_EQ(part.closed, is_closed(alone) ? 1 : 0);
      ++(part.closed == 1 ? closed : open);
      const Eigen::AlignedBox3d box = bounds(alone);
      const auto used = [&](std::int32_t v) { return (alone.triangles.array() == v).any(); };
      EXPECT_TRUE(used(part.vertex));
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_TRUE(used(part.extremes[2 * axis]) && used(part.extremes[2 * axis + 1]));
        EXPECT_EQ(mesh.vertices(part.extremes[2 * axis], axis), box.min()[axis]);
        EXPECT_EQ(mesh.vertices(part.extremes[2 * axis + 1], axis), box.max()[axis]);
      }
    }
    const bool all_closed =
        std::all_of(arrays.parts.begin(), arrays.parts.end(), [](const MeshPart& part) { return part.closed == 1; });
    EXPECT_EQ(all_closed, is_closed(mesh));
    EXPECT_NO_THROW(check_arrays(arrays.view(), "m"));
  }
  EXPECT_GT(open, 20);
  EXPECT_GT(closed, 5);
}

TEST(MeshArrays, CopiesTheMeshExactly) {
  const TriangleMesh mesh = rounded(shapes::torus(1, 0.3, 9, 5));
  const MeshArrays arrays = make_mesh_arrays(mesh, "m");
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(static_cast<double>(arrays.vertices[v][k]), mesh.vertices(v, k));
  }
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(static_cast<std::int32_t>(arrays.triangles[t][k]), mesh.triangles(t, k));
  }
}

TEST(MeshArrays, RefusesWhatNoQueryCanUse) {
  const auto refusal = [](auto&& spoil) {
    TriangleMesh mesh = shapes::cube(1);
    spoil(mesh);
    return error_of([&] { make_mesh_arrays(mesh, "m"); });
  };
  EXPECT_EQ(refusal([](TriangleMesh& m) { m.triangles.resize(0, 3); }), "m: no triangles");
  EXPECT_EQ(refusal([](TriangleMesh& m) { m.triangles(3, 1) = 8; }),
            "m: triangle 3: index 8 is out of range, there are 8 vertices");
  EXPECT_EQ(refusal([](TriangleMesh& m) { m.vertices(5, 2) = std::numeric_limits<double>::infinity(); }),
            "m: vertex 5: not finite");
  EXPECT_EQ(refusal([](TriangleMesh& m) { m.vertices(5, 2) = 1e-60; }),
            "m: vertex 5: 9.9999999999999997e-61 is not exact in float32");
}

TEST(CheckArrays, RefusesWhatLeadsOutOfTheArrays) {
  const auto refusal = [](auto&& spoil) {
    MeshArrays arrays = make_mesh_arrays(shapes::joined(shapes::cube(1), shapes::cube(1)), "m");
    spoil(arrays);
    return error_of([&] { check_arrays(arrays.view(), "m"); });
  };
  EXPECT_EQ(refusal([](MeshArrays& a) { a.owned.pop_back(); }), "m: not one owner entry a triangle");
  EXPECT_EQ(refusal([](MeshArrays& a) { a.owned.push_back(0); }), "m: not one owner entry a triangle");
  EXPECT_EQ(refusal([](MeshArrays& a) { a.parts.clear(); }), "m: no parts");
  for (const std::int32_t bad : {-1, 16, std::numeric_limits<std::int32_t>::max()}) {
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.parts[1].vertex = bad; }), "m: part 1 refers to a vertex out of range");
    for (int k = 0; k < 6; ++k) {
      EXPECT_EQ(refusal([&](MeshArrays& a) { a.parts[1].extremes[k] = bad; }),
                "m: part 1 refers to a vertex out of range");
    }
  }
}

}  // namespace
}  // namespace encage
