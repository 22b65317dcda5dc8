// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/interpenetration.h"

#include "cagegen/certify/box_tree.h"
#include "cagegen/certify/exact.h"

#include <algorithm>
#include <vector>

namespace encage::tank {
namespace {

TriangleMesh placed(const TriangleMesh& mesh, const Eigen::Isometry3d& pose) {
  TriangleMesh world{Vertices(mesh.vertices.rows(), 3), mesh.triangles};
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    world.vertices.row(v) = (pose * mesh.vertices.row(v).transpose().eval()).transpose();
  }
  return world;
}

Eigen::AlignedBox3d box_of(const proof::Corners& t) {
  Eigen::AlignedBox3d box(t[0]);
  return box.extend(t[1]).extend(t[2]);
}

/// The triangles that reach into a box.
TriangleMesh part_in(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  std::vector<std::int64_t> inside;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    if (box.intersects(box_of(proof::corners(mesh, static_cast<std::int32_t>(t))))) inside.push_back(t);
  }
  TriangleMesh part{mesh.vertices, Triangles(static_cast<Eigen::Index>(inside.size()), 3)};
  for (std::size_t k = 0; k < inside.size(); ++k) part.triangles.row(k) = mesh.triangles.row(inside[k]);
  return part;
}

bool touches(const proof::BoxTree& tree, const TriangleMesh& mesh, const proof::Corners& triangle) {
  const Eigen::AlignedBox3d box = box_of(triangle);
  std::vector<std::int32_t> stack = {0};
  while (!stack.empty()) {
    const proof::BoxTree::Node& node = tree.nodes[stack.back()];
    stack.pop_back();
    bool apart = false;
    for (int k = 0; k < 3; ++k) apart |= node.low[k] > box.max()[k] || node.high[k] < box.min()[k];
    if (apart) continue;
    if (node.count == 0) {
      stack.push_back(node.first + 1);
      stack.push_back(node.first);
      continue;
    }
    for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
      if (proof::touch(proof::corners(mesh, tree.order[k]), triangle)) return true;
    }
  }
  return false;
}

bool surfaces_touch(const TriangleMesh& a, const TriangleMesh& b, const Eigen::AlignedBox3d& common) {
  const TriangleMesh part_a = part_in(a, common);
  const TriangleMesh part_b = part_in(b, common);
  if (part_a.triangles.rows() == 0) return false;
  const proof::BoxTree tree(part_a);
  for (std::int32_t t = 0; t < part_b.triangles.rows(); ++t) {
    if (touches(tree, part_a, proof::corners(part_b, t))) return true;
  }
  return false;
}

}  // namespace

std::int64_t interpenetrations(const TriangleMesh& mesh, const PoseStep& step) {
  std::vector<TriangleMesh> worlds;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const BodyPose& body : step.bodies) {
    worlds.push_back(placed(mesh, body.pose));
    boxes.push_back(bounds(worlds.back()));
  }
  std::int64_t count = 0;
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    for (std::size_t j = i + 1; j < worlds.size(); ++j) {
      if (!boxes[i].intersects(boxes[j])) continue;
      count += surfaces_touch(worlds[i], worlds[j], boxes[i].intersection(boxes[j]));
    }
  }
  return count;
}

}  // namespace encage::tank
