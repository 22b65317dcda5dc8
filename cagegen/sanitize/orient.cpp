// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/orient.h"

#include "cagegen/sanitize/nesting.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace encage::io {
namespace {

void turn(Triangles& triangles, std::int32_t t, std::vector<char>& turned) {
  std::swap(triangles(t, 1), triangles(t, 2));
  turned[t] ^= 1;
}

/// Components merged where only several together are closed, as at an edge with four sides that belong to different
/// components.
class Bodies {
 public:
  explicit Bodies(std::int32_t components) : parent_(components), open_(components, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::int32_t root(std::int32_t c) {
    while (parent_[c] != c) c = parent_[c] = parent_[parent_[c]];
    return c;
  }
  bool is_open(std::int32_t c) { return open_[root(c)] != 0; }

  /// Takes in one edge: its sides with the component of each.
  void add_edge(const Triangles& triangles, std::span<const Side> sides, const std::vector<std::int32_t>& label) {
    std::vector<std::pair<std::int32_t, int>>& net = net_;
    net.clear();
    int total = 0;
    for (const Side s : sides) {
      const int direction = tail(triangles, s) < head(triangles, s) ? 1 : -1;
      total += direction;
      const std::int32_t l = label[triangle_of(s)];
      const auto at = std::find_if(net.begin(), net.end(), [&](const auto& n) { return n.first == l; });
      if (at == net.end()) {
        net.emplace_back(l, direction);
      } else {
        at->second += direction;
      }
    }
    std::erase_if(net, [](const auto& n) { return n.second == 0; });
    for (const auto& [l, n] : net) {
      if (total != 0) open_[root(l)] = 1;
      merge(l, net.front().first);
    }
  }

 private:
  void merge(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    open_[std::min(a, b)] |= open_[std::max(a, b)];
  }

  std::vector<std::int32_t> parent_;
  std::vector<char> open_;
  std::vector<std::pair<std::int32_t, int>> net_;  ///< of the edge at hand: component, sum of directions
};

}  // namespace

Components make_consistent(Triangles& triangles, const EdgeTable& edges, std::vector<char>& turned) {
  const std::vector<Side> twin = twins(edges, triangles.rows());
  Components result;
  result.label.assign(static_cast<std::size_t>(triangles.rows()), -1);
  std::vector<char> parity(result.label.size(), 0);
  std::vector<std::int32_t> members;
  for (Eigen::Index seed = 0; seed < triangles.rows(); ++seed) {
    if (result.label[seed] >= 0 || repeats_a_vertex(triangles, seed)) continue;
    const std::int32_t label = result.count++;
    result.label[seed] = label;
    members.assign(1, static_cast<std::int32_t>(seed));
    bool orientable = true, agree = true;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::int32_t t = members[i];
      for (Side s = 3 * t; s < 3 * t + 3; ++s) {
        if (twin[s] < 0) continue;
        const std::int32_t other = triangle_of(twin[s]);
        const bool same_direction = tail(triangles, s) == tail(triangles, twin[s]);
        const char wanted = static_cast<char>(parity[t] ^ (same_direction ? 1 : 0));
        if (result.label[other] < 0) {
          result.label[other] = label;
          parity[other] = wanted;
          agree &= wanted == 0;
          members.push_back(other);
        } else if (parity[other] != wanted) {
          orientable = false;
        }
      }
    }
    if (!orientable || agree) continue;
    for (const std::int32_t t : members) {
      if (parity[t]) turn(triangles, t, turned);
    }
  }
  return result;
}

std::vector<std::vector<std::int32_t>> closed_parts(const TriangleMesh& mesh, const EdgeTable& edges,
                                                    const Components& components) {
  Bodies bodies(components.count);
  edges.for_each_edge([&](std::span<const Side> sides) {
    // The usual edge costs nothing: both sides are in one component.
    if (sides.size() == 2 && tail(mesh.triangles, sides[0]) == head(mesh.triangles, sides[1])) return;
    bodies.add_edge(mesh.triangles, sides, components.label);
  });
  std::vector<std::int32_t> number(static_cast<std::size_t>(components.count), -1);
  std::vector<std::vector<std::int32_t>> parts;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const std::int32_t label = components.label[t];
    if (label < 0 || bodies.is_open(label)) continue;
    std::int32_t& n = number[bodies.root(label)];
    if (n < 0) {
      n = static_cast<std::int32_t>(parts.size());
      parts.emplace_back();
    }
    parts[n].push_back(static_cast<std::int32_t>(t));
  }
  return parts;
}

void turn_outward(TriangleMesh& mesh, const std::vector<std::vector<std::int32_t>>& parts, std::vector<char>& turned) {
  std::vector<int> read(parts.size());  // the sign of the volume as read
  for (std::size_t p = 0; p < parts.size(); ++p) read[p] = part_volume(mesh, parts[p]) < 0 ? -1 : 1;
  if (std::count(read.begin(), read.end(), -1) == 0) return;
  const std::vector<std::vector<std::int32_t>> around = containers(mesh, parts);

  std::vector<std::size_t> order(parts.size());  // outer ones first
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return around[a].size() < around[b].size(); });
  std::vector<int> sign(parts.size(), 1);
  for (const std::size_t p : order) {
    if (!around[p].empty()) {
      int winding = 0;
      for (const std::int32_t outer : around[p]) winding += sign[outer];
      const std::int32_t outermost =
          *std::min_element(around[p].begin(), around[p].end(),
                            [&](std::int32_t a, std::int32_t b) { return around[a].size() < around[b].size(); });
      sign[p] = read[p] * read[outermost] * sign[outermost];
      if (winding + sign[p] < 0) sign[p] = 1;
    }
    if (sign[p] == read[p]) continue;
    for (const std::int32_t t : parts[p]) turn(mesh.triangles, t, turned);
  }
}

}  // namespace encage::io
