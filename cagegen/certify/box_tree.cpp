// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/box_tree.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace encage::proof {
namespace {

constexpr std::int32_t leaf_size = 4;
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Item {
  double centre[3];  ///< three times the centroid
  std::int32_t triangle;
};

std::vector<Item> centroids(const TriangleMesh& mesh) {
  std::vector<Item> items(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d sum = mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2);
    items[t] = {{sum[0], sum[1], sum[2]}, t};
  }
  return items;
}

int longest_axis(const Item* begin, const Item* end) {
  double low[3] = {infinity, infinity, infinity};
  double high[3] = {-infinity, -infinity, -infinity};
  for (const Item* item = begin; item != end; ++item) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], item->centre[k]);
      high[k] = std::max(high[k], item->centre[k]);
    }
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  }
  return axis;
}

void clear(BoxTree::Node& node) {
  for (int k = 0; k < 3; ++k) {
    node.low[k] = infinity;
    node.high[k] = -infinity;
  }
}

void extend(BoxTree::Node& node, const double* low, const double* high) {
  for (int k = 0; k < 3; ++k) {
    node.low[k] = std::min(node.low[k], low[k]);
    node.high[k] = std::max(node.high[k], high[k]);
  }
}

}  // namespace

BoxTree::BoxTree(const TriangleMesh& mesh) {
  assert(mesh.triangles.rows() > 0);
  std::vector<Item> items = centroids(mesh);
  const std::int32_t count = static_cast<std::int32_t>(items.size());
  nodes.reserve(static_cast<std::size_t>(count));
  nodes.push_back({{}, {}, 0, count});
  // Breadth first: a node holds its range of items until its turn to be split.
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const std::int32_t first = nodes[n].first;
    const std::int32_t size = nodes[n].count;
    if (size <= leaf_size) continue;
    Item* const begin = items.data() + first;
    const int axis = longest_axis(begin, begin + size);
    const std::int32_t half = size / 2;
    // Ties by index: the halves are the same sets with every standard library.
    std::nth_element(begin, begin + half, begin + size, [axis](const Item& a, const Item& b) {
      return a.centre[axis] < b.centre[axis] || (a.centre[axis] == b.centre[axis] && a.triangle < b.triangle);
    });
    nodes[n].first = static_cast<std::int32_t>(nodes.size());
    nodes[n].count = 0;
    nodes.push_back({{}, {}, first, half});
    nodes.push_back({{}, {}, first + half, size - half});
  }

  order.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) order[i] = items[i].triangle;
  for (std::size_t n = nodes.size(); n-- > 0;) {
    Node& node = nodes[n];
    clear(node);
    if (node.count == 0) {
      for (int child = 0; child < 2; ++child) {
        const Node& c = nodes[node.first + child];
        extend(node, c.low, c.high);
      }
      continue;
    }
    std::sort(order.begin() + node.first, order.begin() + node.first + node.count);
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      for (int k = 0; k < 3; ++k) {
        const double* corner = mesh.vertices.row(mesh.triangles(order[i], k)).data();
        extend(node, corner, corner);
      }
    }
  }
}

}  // namespace encage::proof
