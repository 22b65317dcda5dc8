// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/intersections.h"

#include "cagegen/certify/exact.h"
#include "cagegen/geometry/triangle_tree.h"

#include <algorithm>
#include <vector>

namespace encage::zoo {

namespace {

Eigen::AlignedBox3d box_of(const proof::Corners& t) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : t) box.extend(p);
  return box;
}

makers::TriangleTree tree_of(const TriangleMesh& mesh) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) boxes.push_back(box_of(proof::corners(mesh, t)));
  return makers::TriangleTree(boxes);
}

/// How many triangles of `cage` are degenerate or meet(t, other) a triangle of the tree.
template <class Meet>
std::int64_t count(const TriangleMesh& cage, const makers::TriangleTree& tree, const Meet& meet) {
  using makers::Float4;
  std::int64_t found = 0;
  for (std::int32_t t = 0; t < cage.triangles.rows(); ++t) {
    const proof::Corners corners = proof::corners(cage, t);
    bool hit = proof::degenerate(corners);
    const Eigen::AlignedBox3d box = box_of(corners);
    const double slack = 1e-6 * (box.min().cwiseAbs() + box.max().cwiseAbs()).maxCoeff();
    Float4 low[3];
    Float4 high[3];
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = Float4::broadcast(static_cast<float>(box.min()[axis] - slack));
      high[axis] = Float4::broadcast(static_cast<float>(box.max()[axis] + slack));
    }
    const auto near = [&](const Float4(&l)[3], const Float4(&h)[3]) {
      makers::Mask4 accepted = (l[0] <= high[0]) & (low[0] <= h[0]);
      for (int axis = 1; axis < 3; ++axis) accepted = accepted & (l[axis] <= high[axis]) & (low[axis] <= h[axis]);
      return accepted;
    };
    tree.traverse(near, [&](std::int32_t other) { hit = hit || meet(t, other); });
    if (hit) ++found;
  }
  return found;
}

/// Neither is degenerate.
bool overlap(const TriangleMesh& mesh, std::int32_t s, std::int32_t t) {
  const proof::Corners a = proof::corners(mesh, s);
  const proof::Corners b = proof::corners(mesh, t);
  std::vector<std::array<int, 2>> shared;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (mesh.triangles(s, i) == mesh.triangles(t, j)) shared.push_back({i, j});
    }
  }
  switch (shared.size()) {
    case 0: return proof::touch(a, b);
    case 1: {
      const auto [i, j] = shared[0];
      return proof::overlap_at_vertex(a[i], a[(i + 1) % 3], a[(i + 2) % 3], b[(j + 1) % 3], b[(j + 2) % 3]);
    }
    case 2: {
      const int apex_s = 3 - shared[0][0] - shared[1][0];
      const int apex_t = 3 - shared[0][1] - shared[1][1];
      return proof::overlap_at_edge(a[(apex_s + 1) % 3], a[(apex_s + 2) % 3], a[apex_s], b[apex_t]);
    }
    default: return true;
  }
}

}  // namespace

std::int64_t touching_triangles(const TriangleMesh& cage, const TriangleMesh& inner) {
  return count(cage, tree_of(inner), [&](std::int32_t t, std::int32_t other) {
    return proof::touch(proof::corners(cage, t), proof::corners(inner, other));
  });
}

std::int64_t self_intersecting_triangles(const TriangleMesh& cage) {
  return count(cage, tree_of(cage), [&](std::int32_t t, std::int32_t other) {
    return other != t && !proof::degenerate(proof::corners(cage, other)) && overlap(cage, t, other);
  });
}

}  // namespace encage::zoo
