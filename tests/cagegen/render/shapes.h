// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <map>
#include <utility>
#include <vector>

namespace encage::test {

/// The cube [-half, half]^3.
inline TriangleMesh cube(double half) {
  TriangleMesh mesh;
  mesh.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v)
    mesh.vertices.row(v) << (v & 1 ? half : -half), (v & 2 ? half : -half), (v & 4 ? half : -half);
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,  //
      2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5;
  return mesh;
}

/// A sphere about 0 by midpoint subdivision of an octahedron: 8 * 4^rounds triangles.
inline TriangleMesh sphere(double radius, int rounds) {
  std::vector<Eigen::Vector3d> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<Eigen::Vector3i> faces{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                     {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int round = 0; round < rounds; ++round) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [place, added] = middles.try_emplace(std::minmax(a, b), static_cast<int>(points.size()));
      if (added) points.push_back((points[a] + points[b]).normalized());
      return place->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (const Eigen::Vector3i& f : faces) {
      const int a = middle(f[0], f[1]), b = middle(f[1], f[2]), c = middle(f[2], f[0]);
      for (const Eigen::Vector3i& g : {Eigen::Vector3i(f[0], a, c), Eigen::Vector3i(f[1], b, a),
                                       Eigen::Vector3i(f[2], c, b), Eigen::Vector3i(a, b, c)}) {
        finer.push_back(g);
      }
    }
    faces = std::move(finer);
  }
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<std::int64_t>(points.size()), 3);
  mesh.triangles.resize(static_cast<std::int64_t>(faces.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.vertices.row(i) = radius * points[i].transpose();
  for (std::size_t i = 0; i < faces.size(); ++i) mesh.triangles.row(i) = faces[i].transpose();
  return mesh;
}

}  // namespace encage::test
