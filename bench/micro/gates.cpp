// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/benches.h"
#include "broadphase/motion/pair_motion.h"
#include "broadphase/separation/box_gate.h"
#include "broadphase/shape/shape.h"
#include "oracles/meshes.h"

#include <hwy/highway.h>

#include <algorithm>
#include <string>
#include <vector>

namespace encage::micro {
namespace {

GateBody body_of(const Surface& surface) { return {surface.radius, surface.tree.grid}; }

BoxGate gate_of(const Workload& w, const Surface& surface, const Case& c) {
  const LocalFrame& frame = w.shape->simple().frame;
  return {pair_motion(frame, c.a, frame, c.b), body_of(surface), body_of(surface),
          required_distance(frame, c.a, frame, c.b, 0)};
}

std::vector<BoxGate> gates_of(const Workload& w, const Surface& surface, bool moving) {
  std::vector<BoxGate> gates;
  for (const Case& c : w.cases) gates.push_back(gate_of(w, surface, moving ? c : c.at_rest()));
  return gates;
}

std::int64_t leaf_pairs(const MeshTreeView& tree, const BoxGate& gate) {
  std::int64_t pairs = 0;
  const auto count = [](void* counter, std::int32_t, std::int32_t, std::int32_t, std::int32_t) {
    ++*static_cast<std::int64_t*>(counter);
    return true;
  };
  visit_leaf_pairs(tree, tree, gate, count, &pairs);
  return pairs;
}

/// Whole traversals on one instruction set: items are pairs of trees.
void traverse(benchmark::State& state, const MeshTreeView& tree, const std::vector<BoxGate>& gates,
              std::int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  std::int64_t pairs = 0;
  for (const BoxGate& gate : gates) pairs += leaf_pairs(tree, gate);
  state.counters["leaf_pairs"] = static_cast<double>(pairs) / static_cast<double>(gates.size());
  ask_in_turn(state, gates, [&](const BoxGate& gate) { return leaf_pairs(tree, gate); });
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

void add_traversals(const std::string& name, const MeshTreeView& tree, const std::vector<BoxGate>& gates) {
  std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  // What remains on the plainest machine.
  if (std::find(targets.begin(), targets.end(), std::int64_t{HWY_STATIC_TARGET}) == targets.end()) {
    targets.push_back(HWY_STATIC_TARGET);
  }
  for (const std::int64_t target : targets) {
    const std::string full = name + "/" + hwy::TargetName(target);
    benchmark::RegisterBenchmark(
        full.c_str(), [&gates, tree, target](benchmark::State& state) { traverse(state, tree, gates, target); });
  }
}

/// One node with eight leaves, met by itself: what a pair of nodes costs, from their boxes to the list of leaves.
struct OneNode {
  MeshArrays arrays = make_mesh_arrays(shapes::sphere(0), "octahedron");
  std::vector<BoxGate> resting, moving;

  OneNode() {
    shapes::Random random(3);
    for (int i = 0; i < 64; ++i) {
      PairMotion motion;
      motion.b[0].linear = Eigen::AngleAxisd(random(-3, 3), random.point(1).normalized()).toRotationMatrix();
      motion.b[0].offset = random.point(1).normalized() * random(0.5, 2);
      motion.b[1] = motion.b[0];
      motion.b[1].offset += random.point(0.1);
      moving.emplace_back(motion, body(), body(), 1e-6);
      motion.b[1] = motion.b[0];
      motion.at_rest = true;
      resting.emplace_back(motion, body(), body(), 1e-6);
    }
  }
  GateBody body() const { return {1.0, arrays.tree.grid}; }
};

}  // namespace

void add_gates(const Workload& w) {
  const Surface& fine = w.shape->simple().fine.empty() ? w.shape->simple().cages.front() : w.shape->simple().fine;
  add("kernel/box_gate/make", w.cases, [&](const Case& c) { return gate_of(w, fine, c).a.works; });
  static const OneNode node;
  add_traversals("kernel/box_gate/one_node/rest", node.arrays.tree, node.resting);
  add_traversals("kernel/box_gate/one_node/moving", node.arrays.tree, node.moving);
  static const std::vector<BoxGate> resting = gates_of(w, fine, false), moving = gates_of(w, fine, true);
  add_traversals("kernel/box_gate/tree/rest", fine.tree, resting);
  add_traversals("kernel/box_gate/tree/moving", fine.tree, moving);
}

}  // namespace encage::micro
