// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "broadphase/separation/box_gate.h"
#include "oracles/meshes.h"
#include "src/tree/mesh_arrays.h"

#include <limits>
#include <utility>
#include <vector>

namespace encage::test {

/// A mesh with its tree, vertices rounded to what assets hold.
struct SampleTree {
  TriangleMesh mesh;
  MeshArrays arrays;
  double radius = 0;

  explicit SampleTree(TriangleMesh m) : mesh(std::move(m)) {
    mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
    // No denormal numbers.
    mesh.vertices = (mesh.vertices.array().abs() < std::numeric_limits<float>::min()).select(0, mesh.vertices);
    arrays = make_mesh_arrays(mesh, "mesh");
    radius = mesh.vertices.rowwise().norm().maxCoeff() * (1 + 1e-12);
  }
  GateBody body(double scale = 1) const { return {radius, arrays.tree.grid, scale}; }
};

/// Of size 1: a torus of m times n vertices and a sphere, flat, thin, degenerate, off the local origin.
inline std::vector<SampleTree> sample_trees(int m, int n, int sphere) {
  std::vector<SampleTree> all;
  all.emplace_back(shapes::torus(1, 0.35, m, n));
  all.emplace_back(shapes::sphere(sphere));
  all.emplace_back(shapes::box({-1, -0.6, 0}, {1, 0.6, 0}));                            // flat
  all.emplace_back(shapes::box({-1, 0, 0}, {1, 0, 0}));                                 // a segment
  all.emplace_back(shapes::mesh({{0.3, 0, 1}, {-1, 0.2, 0}, {0, 1, 0}}, {{0, 1, 2}}));  // one triangle
  all.emplace_back(shapes::mesh({{0.25, 0.5, 0.125}}, {{0, 0, 0}}));                    // a point
  all.emplace_back(shapes::moved(shapes::sphere(1), {3, -2, 1}));                       // off its local origin
  return all;
}

}  // namespace encage::test
