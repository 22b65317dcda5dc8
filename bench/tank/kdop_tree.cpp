// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/kdop_tree.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace encage::tank {
namespace {

// From here on nodes are halved: bad luck with means must not make the tree a list.
constexpr int mean_depth = 48;

}  // namespace

Kdop KdopTree::triangle_dop(std::int32_t triangle) const {
  const std::int32_t* corner = triangles_->data() + 3 * static_cast<std::ptrdiff_t>(triangle);
  Kdop dop = vertices_[corner[0]];
  dop.extend(vertices_[corner[1]]);
  dop.extend(vertices_[corner[2]]);
  return dop;
}

void KdopTree::build(const Sweep& sweep) {
  triangles_ = &sweep.mesh->triangles;
  vertices_.resize(static_cast<std::size_t>(sweep.mesh->vertices.rows()));
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    const auto vertex = static_cast<std::int32_t>(v);
    vertices_[v] = kdop_of(sweep.start_of(vertex), sweep.end_of(vertex), sweep.slack);
  }
  const auto count = static_cast<std::int32_t>(triangles_->rows());
  order_.resize(static_cast<std::size_t>(count));
  for (std::int32_t t = 0; t < count; ++t) {
    const Kdop dop = triangle_dop(t);
    order_[t] = {{dop.middle(0), dop.middle(1), dop.middle(2)}, t};
  }
  nodes_.clear();
  if (count == 0) return;
  build_node(0, count, 0);
  merge_from_leaves();
}

void KdopTree::build_node(std::int32_t begin, std::int32_t end, int depth) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  nodes_[self].first = begin;
  nodes_[self].count = end - begin;
  if (end - begin <= leaf_size) return;
  const std::int32_t middle = partition(begin, end, depth);
  build_node(begin, middle, depth + 1);
  nodes_[self].first = static_cast<std::int32_t>(nodes_.size());
  nodes_[self].count = 0;
  build_node(middle, end, depth + 1);
}

std::int32_t KdopTree::partition(std::int32_t begin, std::int32_t end, int depth) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::array<float, 3> low = {infinity, infinity, infinity}, high = {-infinity, -infinity, -infinity};
  std::array<double, 3> sum = {0, 0, 0};
  for (std::int32_t i = begin; i < end; ++i) {
    for (int k = 0; k < 3; ++k) {
      const float x = order_[i].at[k];
      low[k] = std::min(low[k], x);
      high[k] = std::max(high[k], x);
      sum[k] += static_cast<double>(x);
    }
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  }
  const auto first = order_.begin() + begin, last = order_.begin() + end;
  if (depth < mean_depth) {
    const auto mean = static_cast<float>(sum[axis] / (end - begin));
    const auto middle = std::partition(first, last, [&](const Centre& c) { return c.at[axis] < mean; });
    if (middle != first && middle != last) return static_cast<std::int32_t>(middle - order_.begin());
  }
  const std::int32_t half = begin + (end - begin) / 2;
  std::nth_element(first, order_.begin() + half, last,
                   [&](const Centre& s, const Centre& t) { return s.at[axis] < t.at[axis]; });
  return half;
}

void KdopTree::merge_from_leaves() {
  // Children come after their parent.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    DopNode& node = nodes_[i];
    if (node.count == 0) {
      node.dop = nodes_[i + 1].dop;
      node.dop.extend(nodes_[node.first].dop);
      continue;
    }
    node.dop = triangle_dop(order_[node.first].triangle);
    for (std::int32_t k = 1; k < node.count; ++k) node.dop.extend(triangle_dop(order_[node.first + k].triangle));
  }
}

void KdopTree::leaf_overlaps(const KdopTree& a, const DopNode& leaf_a, const KdopTree& b, const DopNode& leaf_b,
                             std::vector<TrianglePair>& pairs) {
  std::array<Kdop, leaf_size> dops_b;
  for (std::int32_t j = 0; j < leaf_b.count; ++j) dops_b[j] = b.triangle_dop(b.order_[leaf_b.first + j].triangle);
  for (std::int32_t i = 0; i < leaf_a.count; ++i) {
    const std::int32_t triangle = a.order_[leaf_a.first + i].triangle;
    const Kdop dop = a.triangle_dop(triangle);
    if (!dop.overlaps(leaf_b.dop)) continue;
    for (std::int32_t j = 0; j < leaf_b.count; ++j) {
      if (dop.overlaps(dops_b[j])) pairs.push_back({triangle, b.order_[leaf_b.first + j].triangle});
    }
  }
}

void KdopTree::overlaps(const KdopTree& a, const KdopTree& b, std::vector<TrianglePair>& pairs) {
  if (a.nodes_.empty() || b.nodes_.empty()) return;
  const auto size = [](const DopNode& node) { return node.dop.width(0) + node.dop.width(1) + node.dop.width(2); };
  std::vector<std::pair<std::int32_t, std::int32_t>> stack{{0, 0}};
  while (!stack.empty()) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    const DopNode& node_a = a.nodes_[i];
    const DopNode& node_b = b.nodes_[j];
    if (!node_a.dop.overlaps(node_b.dop)) continue;
    if (node_a.count > 0 && node_b.count > 0) {
      leaf_overlaps(a, node_a, b, node_b, pairs);
    } else if (node_b.count > 0 || (node_a.count == 0 && size(node_a) >= size(node_b))) {
      stack.emplace_back(node_a.first, j);
      stack.emplace_back(i + 1, j);
    } else {
      stack.emplace_back(i, node_b.first);
      stack.emplace_back(i, j + 1);
    }
  }
}

}  // namespace encage::tank
