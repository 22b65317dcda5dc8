// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/box_cover.h"

#include "broadphase/separation/box_gate.h"

namespace encage::covers {

BoxCover::BoxCover(const Surface& surface, std::int64_t boxes) {
  const CutTree cut = cut_tree(surface.tree, boxes);
  boxes_ = cut.boxes;
  tree_.grid = surface.tree.grid;
  tree_.leaves.resize(MeshTree::leaf_size);  // nobody looks what is in the last boxes
  for (const std::int32_t index : cut.nodes) {
    MeshNode node = surface.tree.nodes[index];
    for (int lane = 0; lane < MeshNode::width; ++lane) {
      if (node.count(lane) == MeshNode::unused) continue;
      const std::int32_t child = cut.child(node, lane);
      node.set_link(lane, child < 0 ? 0 : child, child < 0 ? 1 : MeshNode::inner);
    }
    tree_.nodes.push_back(node);
  }
}

bool covers_apart(const BoxCover& a, const Surface& surface_a, const BoxCover& b, const Surface& surface_b,
                  const PairMotion& motion, double distance) {
  const auto stop = [](void*, std::int32_t, std::int32_t, std::int32_t, std::int32_t) { return false; };
  return visit_intervals(surface_a, surface_b, motion, distance, [&](double t0, double t1) {
    const BoxGate gate(motion.part(t0, t1), {surface_a.radius, a.tree().grid}, {surface_b.radius, b.tree().grid},
                       distance);
    return visit_leaf_pairs(a.tree(), b.tree(), gate, stop, nullptr);
  });
}

}  // namespace encage::covers
