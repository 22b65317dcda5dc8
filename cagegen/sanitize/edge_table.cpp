// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/edge_table.h"

#include <algorithm>

namespace encage::io {

EdgeTable::EdgeTable(const Triangles& triangles, Eigen::Index vertex_count)
    : first_(static_cast<std::size_t>(vertex_count) + 1, 0) {
  const auto for_each_side = [&](const auto& visit) {
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
      if (repeats_a_vertex(triangles, t)) continue;
      for (int k = 0; k < 3; ++k) visit(static_cast<Side>(3 * t + k));
    }
  };
  const auto low = [&](Side s) { return std::min(tail(triangles, s), head(triangles, s)); };
  for_each_side([&](Side s) { ++first_[low(s) + 1]; });
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];

  struct Use {
    std::int32_t high;
    Side side;
    bool operator<(const Use& other) const { return high != other.high ? high < other.high : side < other.side; }
  };
  std::vector<Use> uses(static_cast<std::size_t>(first_.back()));
  std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
  for_each_side([&](Side s) { uses[next[low(s)]++] = {std::max(tail(triangles, s), head(triangles, s)), s}; });
  high_.resize(uses.size());
  sides_.resize(uses.size());
  for (std::size_t v = 0; v + 1 < first_.size(); ++v) {
    std::sort(uses.begin() + first_[v], uses.begin() + first_[v + 1]);
    for (std::int64_t i = first_[v]; i < first_[v + 1]; ++i) {
      high_[i] = uses[i].high;
      sides_[i] = uses[i].side;
    }
  }
}

std::span<const Side> EdgeTable::sides(std::int32_t a, std::int32_t b) const {
  const auto begin = high_.begin() + first_[std::min(a, b)], end = high_.begin() + first_[std::min(a, b) + 1];
  const auto [from, to] = std::equal_range(begin, end, std::max(a, b));
  return {sides_.data() + (from - high_.begin()), static_cast<std::size_t>(to - from)};
}

std::vector<Side> twins(const EdgeTable& edges, Eigen::Index triangle_count) {
  std::vector<Side> twin(static_cast<std::size_t>(3 * triangle_count), -1);
  edges.for_each_edge([&](std::span<const Side> sides) {
    if (sides.size() != 2) return;
    twin[sides[0]] = sides[1];
    twin[sides[1]] = sides[0];
  });
  return twin;
}

bool is_closed_manifold(const Triangles& triangles, Eigen::Index vertex_count) {
  const std::vector<Side> twin = twins(EdgeTable(triangles, vertex_count), triangles.rows());
  std::vector<std::int32_t> degree(static_cast<std::size_t>(vertex_count), 0);
  std::vector<Side> any(static_cast<std::size_t>(vertex_count), -1);
  for (std::size_t s = 0; s < twin.size(); ++s) {
    const Side side = static_cast<Side>(s);
    if (twin[s] < 0 || tail(triangles, side) != head(triangles, twin[s])) return false;
    ++degree[tail(triangles, side)];
    any[tail(triangles, side)] = side;
  }
  for (std::size_t v = 0; v < degree.size(); ++v) {
    if (any[v] < 0) continue;
    std::int32_t visited = 0;
    Side side = any[v];
    do {
      const Side previous = side % 3 == 0 ? side + 2 : side - 1;  // ends in v
      side = twin[previous];                                      // begins in v
      ++visited;
    } while (side != any[v]);
    if (visited != degree[v]) return false;
  }
  return true;
}

}  // namespace encage::io
