// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/certify/separation.h"
#include "cagegen/contact/contact_solver.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

// Cages around obstacles, and what is expected of where contacts leave them.
namespace encage::makers::shapes {

constexpr double test_clearance = 1e-3;

inline ContactSolverOptions contact_options(int threads = 1, double self_clearance = test_clearance) {
  return {test_clearance, self_clearance, threads, [] {}};
}

struct Nested {
  std::string name;
  TriangleMesh inner;
  TriangleMesh cage;
};

/// Flat box of n x n squares above and below.
inline TriangleMesh slab(int n, double half, double thickness) {
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> f;
  const int row = n + 1;
  for (int side = 0; side < 2; ++side) {
    for (int i = 0; i < row * row; ++i) {
      v.push_back({half * (2.0 * (i % row) / n - 1), half * (2.0 * (i / row) / n - 1), (side - 0.5) * thickness});
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int a = i * row + j, b = a + 1, c = a + row, d = c + 1, up = row * row;
      f.insert(f.end(), {{a, c, d}, {a, d, b}, {a + up, b + up, d + up}, {a + up, d + up, c + up}});
    }
    const auto wall = [&](int from, int to) {
      const int up = row * row;
      f.insert(f.end(), {{from, to, to + up}, {from, to + up, from + up}});
    };
    wall(i, i + 1);
    wall(n * row + i + 1, n * row + i);
    wall((i + 1) * row, i * row);
    wall(i * row + n, (i + 1) * row + n);
  }
  return rounded(mesh(v, f));
}

inline std::vector<Nested> nested() {
  return {{"sphere", shapes::scaled(sphere(2), 0.8), rounded(sphere(2))},
          {"torus", torus(1, 0.2, 16, 8), rounded(torus(1, 0.35, 12, 7))},
          {"two spheres", joined(scaled(sphere(1), 0.6), moved(scaled(sphere(1), 0.6), {2.05, 0, 0})),
           rounded(joined(sphere(1), moved(sphere(1), {2.05, 0, 0})))},
          {"slab", slab(3, 0.9, 0.01), slab(4, 1, 0.03)},
          {"box in a tetrahedron", cube(0.2, {0.5, 0.5, 0.5}), rounded(tetrahedron(3))}};
}

inline ContactSolver::Positions positions(const TriangleMesh& mesh) {
  ContactSolver::Positions result;
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) result.push_back(mesh.vertices.row(v).transpose());
  return result;
}

inline TriangleMesh at(TriangleMesh cage, const ContactSolver::Positions& positions) {
  for (std::size_t v = 0; v < positions.size(); ++v) {
    cage.vertices.row(static_cast<std::int64_t>(v)) = positions[v].transpose();
  }
  return cage;
}

/// The makers' boxes tell apart more than their separating axes: what counts is the distance.
inline bool keep(const Corners& s, const Corners& t, double clearance) {
  return separated(s, t, clearance) || proof::separate(s, t).lower > clearance * (1 - 1e-9);
}

/// No pair of triangles closer than allowed, all tested with all. Cage faces that are where they were at the `start`
/// may keep less.
inline void expect_all_apart(const TriangleMesh& inner, const TriangleMesh& cage, const TriangleMesh& start,
                             double self_clearance) {
  const auto index = [&](std::int64_t t) -> std::array<std::int32_t, 3> {
    return {cage.triangles(t, 0), cage.triangles(t, 1), cage.triangles(t, 2)};
  };
  for (std::int64_t s = 0; s < cage.triangles.rows(); ++s) {
    const Corners mine = corners(cage, s);
    for (std::int64_t t = 0; t < inner.triangles.rows(); ++t) {
      EXPECT_TRUE(keep(mine, corners(inner, t), test_clearance)) << "face " << s << " and triangle " << t;
    }
    for (std::int64_t t = 0; t < s; ++t) {
      const Corners theirs = corners(cage, t);
      if (mine == corners(start, s) && theirs == corners(start, t)) continue;
      if (separated(index(s), mine, index(t), theirs, self_clearance)) continue;
      const bool neighbours = (cage.triangles.row(s).array() == cage.triangles(t, 0)).any() ||
                              (cage.triangles.row(s).array() == cage.triangles(t, 1)).any() ||
                              (cage.triangles.row(s).array() == cage.triangles(t, 2)).any();
      EXPECT_TRUE(!neighbours && keep(mine, theirs, self_clearance)) << "faces " << s << " and " << t;
    }
  }
}

inline void expect_certified(const TriangleMesh& inner, const TriangleMesh& cage) {
  const CertifyResult proof = certify(inner, Solid::closed, cage);
  ASSERT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, 0.999 * test_clearance);
  EXPECT_EQ(cage.vertices, rounded(cage).vertices) << "not float32";
}

}  // namespace encage::makers::shapes
