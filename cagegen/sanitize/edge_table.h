// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <span>
#include <vector>

namespace encage::io {

/// A side of a triangle: side k of triangle t runs from its corner k to corner k + 1.
using Side = std::int32_t;  ///< 3 t + k

inline std::int32_t triangle_of(Side side) { return side / 3; }
inline std::int32_t tail(const Triangles& triangles, Side side) { return triangles.data()[side]; }
inline std::int32_t head(const Triangles& triangles, Side side) {
  return triangles.data()[side % 3 == 2 ? side - 2 : side + 1];
}
inline bool repeats_a_vertex(const Triangles& triangles, std::int64_t t) {
  return triangles(t, 0) == triangles(t, 1) || triangles(t, 1) == triangles(t, 2) || triangles(t, 2) == triangles(t, 0);
}

/// The sides of all triangles, grouped by undirected edge: linear time, sorted by the lower vertex, then the higher
/// one, then the side. Triangles that repeat a vertex are left out, as in is_closed().
class EdgeTable {
 public:
  EdgeTable(const Triangles& triangles, Eigen::Index vertex_count);

  /// Calls visit(std::span<const Side>) for every edge, with all sides on it.
  template <typename Visit>
  void for_each_edge(const Visit& visit) const {
    for (std::size_t low = 0; low + 1 < first_.size(); ++low) {
      for (std::int64_t begin = first_[low], end; begin < first_[low + 1]; begin = end) {
        for (end = begin + 1; end < first_[low + 1] && high_[end] == high_[begin];) ++end;
        visit(std::span(&sides_[begin], static_cast<std::size_t>(end - begin)));
      }
    }
  }

  /// The sides on the edge between two vertices, in either direction.
  std::span<const Side> sides(std::int32_t a, std::int32_t b) const;

 private:
  std::vector<std::int64_t> first_;  ///< per vertex: where the edges to higher vertices begin
  std::vector<std::int32_t> high_;
  std::vector<Side> sides_;
};

/// For every side the opposite one on its edge, -1 unless exactly two sides are on it.
std::vector<Side> twins(const EdgeTable& edges, Eigen::Index triangle_count);

/// True if every edge has exactly two sides, in opposite directions, and the triangles around every vertex form one
/// fan.
bool is_closed_manifold(const Triangles& triangles, Eigen::Index vertex_count);

}  // namespace encage::io
