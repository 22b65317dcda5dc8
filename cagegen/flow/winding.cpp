// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/winding.h"

#include "cagegen/flow/angle.h"

#include <algorithm>
#include <cmath>

namespace encage::makers {

namespace {

constexpr double full_angle = 12.566370614359172;
constexpr std::int32_t leaf_triangles = 8;
// A node this many radii away counts as a dipole: Barill et al. use 2; 3 keeps the error of a node below about 1 %.
constexpr double far_radii = 3;

Point centroid(const Corners& t) { return (t[0] + t[1] + t[2]) / 3; }

}  // namespace

double winding_of_triangle(const Point& p, const Corners& t) {
  // Van Oosterom and Strackee 1983.
  const Point a = t[0] - p;
  const Point b = t[1] - p;
  const Point c = t[2] - p;
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double volume = a.dot(b.cross(c));
  const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  // In the triangle's plane either half-turn would do: count neither.
  return volume == 0 ? 0 : 2 * arc_tangent(volume, rest) / full_angle;
}

WindingNumber::WindingNumber(const TriangleMesh& mesh) {
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    triangles_.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  }
  if (!triangles_.empty()) build(triangles_, 0);
}

std::int32_t WindingNumber::build(std::span<Corners> triangles, std::int32_t first) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  Node node;
  node.first = first;
  node.last = first + static_cast<std::int32_t>(triangles.size());
  double area = 0;
  Eigen::AlignedBox3d box;
  for (const Corners& t : triangles) {
    const Point vector = (t[1] - t[0]).cross(t[2] - t[0]) / 2;
    node.dipole += vector;
    area += vector.norm();
    node.centre += vector.norm() * centroid(t);
    for (const Point& p : t) box.extend(p);
  }
  node.centre = area > 0 ? Point(node.centre / area) : Point(box.center());
  for (const Corners& t : triangles) {
    for (const Point& p : t) node.reach2 = std::max(node.reach2, (p - node.centre).squaredNorm());
  }
  node.reach2 *= far_radii * far_radii;
  if (node.last - first > leaf_triangles) {
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const auto middle = triangles.begin() + static_cast<std::ptrdiff_t>(triangles.size() / 2);
    std::stable_sort(triangles.begin(), triangles.end(),
                     [&](const Corners& s, const Corners& t) { return centroid(s)[axis] < centroid(t)[axis]; });
    build({triangles.begin(), middle}, first);
    node.right = build({middle, triangles.end()}, first + static_cast<std::int32_t>(triangles.size() / 2));
  }
  nodes_[index] = node;
  return index;
}

double WindingNumber::operator()(const Point& p) const {
  if (nodes_.empty()) return 0;
  double sum = 0;
  std::int32_t stack[64];  // halves of halves of at most 2^31 triangles
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const Node& node = nodes_[index];
    const Point to = node.centre - p;
    const double distance2 = to.squaredNorm();
    if (distance2 > node.reach2) {
      sum += node.dipole.dot(to) / (full_angle * distance2 * std::sqrt(distance2));
    } else if (node.right == 0) {
      for (std::int32_t t = node.first; t < node.last; ++t) sum += winding_of_triangle(p, triangles_[t]);
    } else {
      stack[size++] = node.right;
      stack[size++] = index + 1;
    }
  }
  return sum;
}

}  // namespace encage::makers
