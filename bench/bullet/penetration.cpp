// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/penetration.h"

#include <algorithm>

namespace encage::bullet_bench {
namespace {

constexpr double long_edge = 0.02;  // of the diagonal of the bounding box
constexpr std::int32_t leaf_size = 8;

std::vector<Eigen::Vector3d> surface_samples(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> samples;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) samples.push_back(mesh.vertex(v));
  const double limit = long_edge * bounds(mesh).diagonal().norm();
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    const double longest = std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
    if (longest <= limit) continue;
    // Long faces get a grid of samples, edges included.
    const int n = std::clamp(static_cast<int>(longest / limit) + 1, 2, 16);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) samples.emplace_back((a * i + b * j + c * (n - i - j)) / n);
    }
    samples.emplace_back((a + b + c) / 3);
  }
  return samples;
}

}  // namespace

PenetrationProbe::PenetrationProbe(const TriangleMesh& mesh) : distance_(mesh), samples_(surface_samples(mesh)) {
  build(0, static_cast<std::int32_t>(samples_.size()));
}

std::int32_t PenetrationProbe::build(std::int32_t first, std::int32_t last) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box;
  for (std::int32_t i = first; i < last; ++i) box.extend(samples_[i]);
  Node node;
  node.centre = box.center();
  node.first = first;
  node.last = last;
  for (std::int32_t i = first; i < last; ++i) node.radius = std::max(node.radius, (samples_[i] - node.centre).norm());
  if (last - first > leaf_size) {
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::int32_t middle = first + (last - first) / 2;
    std::nth_element(samples_.begin() + first, samples_.begin() + middle, samples_.begin() + last,
                     [axis](const Eigen::Vector3d& p, const Eigen::Vector3d& q) { return p[axis] < q[axis]; });
    build(first, middle);
    node.right = build(middle, last);
  }
  nodes_[index] = node;
  return index;
}

template <class Depth>
double PenetrationProbe::deepest(double least, const Depth& depth) const {
  struct Entry {
    std::int32_t node;
    double bound;
  };
  const auto bound = [&](std::int32_t node) { return depth(nodes_[node].centre) + nodes_[node].radius; };
  std::vector<Entry> stack = {{0, bound(0)}};
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    if (entry.bound <= least) continue;
    const Node& node = nodes_[entry.node];
    if (node.right == 0) {
      for (std::int32_t i = node.first; i < node.last; ++i) least = std::max(least, depth(samples_[i]));
      continue;
    }
    Entry near{entry.node + 1, bound(entry.node + 1)}, far{node.right, bound(node.right)};
    if (near.bound < far.bound) std::swap(near, far);
    stack.push_back(far);
    stack.push_back(near);
  }
  return least;
}

double PenetrationProbe::deepest_in(const PenetrationProbe& other, const Eigen::Isometry3d& to_other,
                                    double least) const {
  std::int32_t start = 0;
  return deepest(least, [&](const Eigen::Vector3d& sample) {
    const makers::Nearest nearest = other.distance_.nearest(to_other * sample, start);
    start = nearest.triangle;
    return -nearest.distance;
  });
}

double PenetrationProbe::below(const Eigen::Isometry3d& pose, const HalfSpace& solid) const {
  return deepest(0, [&](const Eigen::Vector3d& sample) { return solid.offset - solid.normal.dot(pose * sample); });
}

double penetration(const PenetrationProbe& a, const Eigen::Isometry3d& pose_a, const PenetrationProbe& b,
                   const Eigen::Isometry3d& pose_b) {
  const double gap = (pose_a * a.nodes_[0].centre - pose_b * b.nodes_[0].centre).norm();
  if (gap > a.nodes_[0].radius + b.nodes_[0].radius) return 0;
  const Eigen::Isometry3d a_to_b = pose_b.inverse() * pose_a;
  const double depth = a.deepest_in(b, a_to_b, 0);
  return b.deepest_in(a, a_to_b.inverse(), depth);
}

}  // namespace encage::bullet_bench
