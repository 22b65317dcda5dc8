// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/decimate.h"

#include "cagegen/decimate/self_contact.h"
#include "tests/cagegen/decimate/shapes.h"

#include <encage/decimator.h>
#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace encage::makers {
namespace {

constexpr Decimation kinds[] = {Decimation::regular, Decimation::adaptive};
const auto no_check = [] {};

TriangleMesh thin_stack(std::uint32_t seed) {
  TriangleMesh plate = shapes::bumpy_sphere(4, seed, 0.03);
  plate.vertices.col(2) *= 0.02;
  return shapes::joined(plate, shapes::moved(plate, {0.02, 0.01, 0.045}));
}

TEST(Decimate, FreeOfSelfContact) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const TriangleMesh stack = thin_stack(seed);
    for (const Decimation kind : kinds) {
      for (const std::int64_t faces : {800, 200, 60}) {
        const auto coarse = decimate(stack, faces, kind, 1e-4, no_check);
        ASSERT_TRUE(coarse);
        EXPECT_LE(coarse->triangles.rows(), 2 * faces);
        shapes::expect_manifold(*coarse, 0, 2);
        EXPECT_TRUE(shapes::embedded(*coarse));
        EXPECT_TRUE(self_contacts(*coarse, 1e-4).empty());
        EXPECT_EQ(coarse->vertices, shapes::rounded(*coarse).vertices);
      }
    }
  }
}

TEST(Decimate, WithMoreFacesWhereItMust) {
  TriangleMesh chain = shapes::torus(1, 0.2, 24, 12);
  for (int i = 1; i < 5; ++i) {
    chain = shapes::joined(chain, shapes::moved(shapes::torus(1, 0.2, 24, 12), {3.0 * i, 0, 0}));
  }
  for (const Decimation kind : kinds) {
    const auto coarse = decimate(chain, 60, kind, 1e-4, no_check);
    if (coarse) {
      EXPECT_GE(coarse->triangles.rows(), 70) << "five tori";
      EXPECT_LE(coarse->triangles.rows(), 120);
      shapes::expect_manifold(*coarse, 5, 5);
    }
    EXPECT_FALSE(decimate(chain, 30, kind, 1e-4, no_check));
  }
}

TEST(Decimate, NotWhatIntersectsItselfThroughout) {
  const TriangleMesh twice = shapes::joined(shapes::sphere(3), shapes::moved(shapes::sphere(3), {0.01, 0, 0}));
  EXPECT_FALSE(decimate(twice, 100, Decimation::regular, 1e-4, no_check));
}

TEST(Decimate, CanBeCancelled) {
  const auto cancel = [] { throw Cancelled(); };
  EXPECT_THROW(decimate(shapes::sphere(4), 100, Decimation::adaptive, 1e-4, cancel), Cancelled);
}

TEST(Decimators, MakeCoarseMeshes) {
  const TriangleMesh torus = shapes::torus(1, 0.4, 60, 30);
  for (const Decimator& decimator : {regular_decimator(), adaptive_decimator()}) {
    const TriangleMesh coarse = decimator(torus, torus, 200);
    EXPECT_EQ(coarse.triangles.rows(), 200);
    shapes::expect_manifold(coarse, 1, 1);
    EXPECT_TRUE(shapes::embedded(coarse));
    const TriangleMesh again = decimator(torus, shapes::sphere(1), 200);
    EXPECT_EQ(again.vertices, coarse.vertices) << "of the finer mesh, and the same each time";
    EXPECT_EQ(again.triangles, coarse.triangles);
  }
}

/// Standard deviation of the triangles' areas over their mean.
double unevenness(const TriangleMesh& mesh) {
  Eigen::ArrayXd area(mesh.triangles.rows());
  for (std::int64_t t = 0; t < area.size(); ++t) {
    area[t] = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
  }
  return std::sqrt((area - area.mean()).square().mean()) / area.mean();
}

TEST(Decimators, AdaptiveSpendsTrianglesWhereTheSurfaceBends) {
  TriangleMesh dome = shapes::sphere(4);
  for (std::int64_t v = 0; v < dome.vertices.rows(); ++v) dome.vertices(v, 2) = std::max(dome.vertices(v, 2), -0.1);
  EXPECT_GT(unevenness(adaptive_decimator()(dome, dome, 200)), 1.15 * unevenness(regular_decimator()(dome, dome, 200)));
}

std::string failure(const Decimator& decimator, const TriangleMesh& mesh, std::int64_t faces) {
  try {
    decimator(mesh, mesh, faces);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Decimators, NameWhatTheyCannotDo) {
  const TriangleMesh torus = shapes::torus(1, 0.4, 24, 12);
  for (const Decimator& decimator : {regular_decimator(), adaptive_decimator()}) {
    EXPECT_EQ(failure(decimator, torus, 3), "decimation to 3 faces: a closed mesh has at least 4");
    EXPECT_EQ(failure(decimator, torus, -1), "decimation to -1 faces: a closed mesh has at least 4");
    const std::string stuck = failure(decimator, torus, 12);
    EXPECT_TRUE(stuck.starts_with("decimation to 12 faces: no edge of ")) << stuck;
    const TriangleMesh twice = shapes::joined(shapes::sphere(3), shapes::moved(shapes::sphere(3), {0.01, 0, 0}));
    EXPECT_EQ(failure(decimator, twice, 100), "decimation to 100 faces: the result intersects itself");
    TriangleMesh open = shapes::sphere(2);
    open.triangles.conservativeResize(100, 3);
    EXPECT_EQ(failure(decimator, open, 40), "decimation: the mesh is not a closed oriented manifold");
  }
}

}  // namespace
}  // namespace encage::makers
