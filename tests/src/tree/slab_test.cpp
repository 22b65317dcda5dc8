// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/tree/slab.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace encage {
namespace {

/// Triangles within 1e-3 of a plane that is askew to all axes; the patch is 1 wide.
TriangleMesh askew_patch(shapes::Random& random, Eigen::Vector3d& normal) {
  normal = random.point(1).normalized();
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  TriangleMesh mesh;
  mesh.vertices.resize(60, 3);
  mesh.triangles.resize(20, 3);
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3d x = random(-0.5, 0.5) * u + random(-0.5, 0.5) * v + random(-5e-4, 5e-4) * normal;
    mesh.vertices.row(k) = x.cast<float>().cast<double>().transpose();
    mesh.triangles(k / 3, k % 3) = k;
  }
  return mesh;
}

struct Fitted {
  Slab slab;
  double low = std::numeric_limits<double>::infinity(), high = -low;  // heights of the corners, in slab units
};

Fitted fit_all(const TriangleMesh& mesh) {
  std::vector<std::array<float, 3>> vertices(static_cast<std::size_t>(mesh.vertices.rows()));
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k) vertices[v][k] = static_cast<float>(mesh.vertices(v, k));
  }
  const TreeGrid grid = make_grid(vertices);
  std::vector<std::int32_t> order(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(order.begin(), order.end(), 0);
  Fitted fitted{SlabFitter(mesh, grid, order).fit(0, static_cast<std::int32_t>(order.size()))};
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      long double height = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const long double coordinate =
            (static_cast<long double>(mesh.corner(t, k)[axis]) - grid.middle[axis]) / grid.step;
        height += fitted.slab.normal[axis] * coordinate;
      }
      fitted.low = std::min(fitted.low, static_cast<double>(height / MeshNode::slab_unit));
      fitted.high = std::max(fitted.high, static_cast<double>(height / MeshNode::slab_unit));
    }
  }
  return fitted;
}

TEST(Slabs, HoldEveryCornerAndNotMuchMore) {
  shapes::Random random(3);
  for (int round = 0; round < 300; ++round) {
    Eigen::Vector3d normal;
    TriangleMesh mesh = askew_patch(random, normal);
    if (round % 3 == 0) mesh = shapes::moved(mesh, random.point(1e4));
    if (round % 5 == 0) mesh.vertices *= 0x1p-60;
    const Fitted fitted = fit_all(mesh);
    EXPECT_LE(fitted.slab.lower, fitted.low);
    EXPECT_GE(fitted.slab.upper, fitted.high);
    EXPECT_GT(fitted.slab.lower, fitted.low - 1.01);
    EXPECT_LT(fitted.slab.upper, fitted.high + 1.01);
  }
}

TEST(Slabs, LieAlongASurfaceThatIsNearlyFlat) {
  shapes::Random random(4);
  for (int round = 0; round < 100; ++round) {
    Eigen::Vector3d normal;
    const Fitted fitted = fit_all(askew_patch(random, normal));
    const Eigen::Vector3d found(fitted.slab.normal[0], fitted.slab.normal[1], fitted.slab.normal[2]);
    EXPECT_GT(std::abs(found.dot(normal)), 0.999 * found.norm());
    // The whole patch is about 127 * 65536 / 256 units wide.
    EXPECT_LT(fitted.slab.upper - fitted.slab.lower, 0.02 * 127 * 256);
  }
}

TEST(Slabs, HoldPointsAndSegments) {
  for (const TriangleMesh& mesh :
       {shapes::mesh({{1, 2, 3}}, {{0, 0, 0}}), shapes::mesh({{1, 2, 3}, {2, 5, -1}}, {{0, 1, 0}})}) {
    const Fitted fitted = fit_all(mesh);
    EXPECT_LE(fitted.slab.lower, fitted.low);
    EXPECT_GE(fitted.slab.upper, fitted.high);
    EXPECT_LE(fitted.slab.upper - fitted.slab.lower, 600);  // because rounded normals retain some of a segment's length
  }
}

}  // namespace
}  // namespace encage
