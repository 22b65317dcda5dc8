// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace encage {

using Edge = std::array<std::int32_t, 2>;  ///< two vertices, the lower one first

/// The edges of a mesh, each once, in increasing order.
inline std::vector<Edge> edges_of(const Triangles& triangles) {
  std::vector<Edge> edges;
  edges.reserve(static_cast<std::size_t>(3 * triangles.rows()));
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = triangles(t, k), b = triangles(t, (k + 1) % 3);
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace encage
