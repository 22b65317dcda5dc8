// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/benches.h"
#include "broadphase/shape/shape.h"
#include "broadphase/world/body_tree.h"
#include "oracles/meshes.h"

#include <encage/world.h>
#include <encage/world_queries.h>

#include <cmath>
#include <vector>

namespace encage::micro {
namespace {

/// `count` bodies in a cube, so dense that each one's box meets a few others; two places for each, a step apart.
std::vector<Motion> crowd(std::int64_t count, double radius) {
  shapes::Random random(4);
  const double half = 1.2 * radius * std::cbrt(static_cast<double>(count));
  std::vector<Motion> motions;
  for (std::int64_t i = 0; i < count; ++i) {
    Motion m;
    m.start.linear() = Eigen::AngleAxisd(random(-3, 3), random.point(1).normalized()).toRotationMatrix();
    m.start.translation() = random.point(half);
    m.end = m.start;
    m.end.translation() += random.point(0.02 * radius);
    motions.push_back(m);
  }
  return motions;
}

FloatBox box_at(const Eigen::Vector3d& centre, double half) {
  return FloatBox::around({(centre.array() - half).matrix(), (centre.array() + half).matrix()});
}

/// All leaves move; then the pairs. Items are bodies.
void box_tree(benchmark::State& state) {
  const std::vector<Motion> motions = crowd(state.range(0), 1);
  BodyTree tree;
  std::vector<BodyTree::Leaf> leaves;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    leaves.push_back(tree.insert(box_at(motions[i].start.translation(), 0.6), static_cast<std::uint32_t>(i)));
  }
  tree.clear_moved();
  std::int64_t pairs = 0;
  bool back = false;
  for (auto _ : state) {
    back = !back;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const Eigen::Vector3d& at = (back ? motions[i].end : motions[i].start).translation();
      tree.update(leaves[i], box_at(at, 0.6));
    }
    tree.refresh();
    tree.query_moved_pairs(0, [&](std::uint32_t, std::uint32_t) { ++pairs; });
    tree.clear_moved();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.counters["pairs"] = benchmark::Counter(static_cast<double>(pairs), benchmark::Counter::kAvgIterations);
}

/// A world of a crowd of one shape that is asked about world boxes alone.
struct Crowd {
  Crowd(std::int64_t count, const ShapePtr& shape) : motions(crowd(count, shape->simple().frame.radius)) {
    options.pair.cages = CageUse::never;
    options.pair.fine = false;
    const ShapeId id = world.add_shape(shape);
    for (const Motion& m : motions) bodies.push_back(world.add_body(id, m.start));
  }

  /// Every `stride`th body goes on, or back; then the search.
  void step(std::size_t stride = 1) {
    back = !back;
    for (std::size_t i = 0; i < bodies.size(); i += stride) {
      const Motion& m = motions[i];
      world.set_motion(bodies[i], back ? m : Motion{m.end, m.start});
    }
    pairs += world.find_candidates(options, [](const CandidatePair&) {}).candidates;
  }

  std::vector<Motion> motions;
  World world;
  std::vector<BodyId> bodies;
  CandidateOptions options;
  bool back = false;
  std::int64_t pairs = 0;
};

void report(benchmark::State& state, std::int64_t items, std::int64_t pairs) {
  state.SetItemsProcessed(state.iterations() * items);
  state.counters["pairs"] = benchmark::Counter(static_cast<double>(pairs), benchmark::Counter::kAvgIterations);
}

/// Every body gets a new motion, then all pairs are found whose world boxes are not apart. Items are bodies.
void collect(benchmark::State& state, const ShapePtr& shape) {
  Crowd c(state.range(0), shape);
  for (auto _ : state) c.step();
  report(state, state.range(0), c.pairs);
}

/// A hundred bodies move, all others sleep. Items are those that move.
void sleep(benchmark::State& state, const ShapePtr& shape) {
  constexpr std::int64_t awake = 100;
  Crowd c(state.range(0), shape);
  const auto stride = static_cast<std::size_t>(state.range(0) / awake);
  for (std::size_t i = 0; i < c.bodies.size(); ++i) c.world.set_awake(c.bodies[i], i % stride == 0);
  c.step(stride);
  c.step(stride);
  c.pairs = 0;
  for (auto _ : state) c.step(stride);
  report(state, awake, c.pairs);
}

/// The state is copied and put back. Items are bodies.
void rollback(benchmark::State& state, const ShapePtr& shape) {
  Crowd c(state.range(0), shape);
  c.step();
  WorldSnapshot taken;
  for (auto _ : state) {
    c.world.snapshot(taken);
    c.world.restore(taken);
  }
  report(state, state.range(0), 0);
}

/// Rays from beside each body of a crowd to a place beside another one.
std::vector<Ray> rays_among(const std::vector<Motion>& motions, double radius) {
  shapes::Random random(5);
  std::vector<Ray> rays;
  for (const Motion& from : motions) {
    const auto to = static_cast<std::size_t>(random.integer(static_cast<int>(motions.size())));
    rays.push_back({.origin = from.start.translation() + random.point(radius),
                    .direction = motions[to].start.translation() + random.point(radius) - from.start.translation()});
    if (rays.back().direction.isZero(0)) rays.back().direction = Eigen::Vector3d::UnitX();
  }
  return rays;
}

enum class RayCaster { tree, changed, every_body };

/// First hits of rays in a world of bodies at rest: by its tree, by boxes of bodies that have changed, or by asking
/// every body. The share of rays that hit comes as a counter.
void world_rays(benchmark::State& state, const ShapePtr& shape, RayCaster caster) {
  Crowd c(state.range(0), shape);
  if (caster == RayCaster::tree) c.world.update_boxes();
  const std::vector<Ray> rays = rays_among(c.motions, shape->simple().frame.radius);
  const auto every_body = [&](const Ray& ray) {
    WorldRayHit first;
    for (std::size_t i = 0; i < c.bodies.size(); ++i) {
      const RayResult result = cast_ray(*shape, c.motions[i], ray);
      if (result.answer == RayAnswer::miss) continue;
      if (first.answer != RayAnswer::miss && first.hit.t <= result.hit.t) continue;
      first = {result.answer, {.body = c.bodies[i]}, result.hit};
    }
    return first;
  };
  const auto ask = [&](const Ray& ray) {
    return caster == RayCaster::every_body ? every_body(ray) : cast_ray(c.world, ray);
  };
  std::int64_t hits = 0;
  for (const Ray& ray : rays) hits += ask(ray).answer == RayAnswer::hit;
  state.counters["hit"] = static_cast<double>(hits) / static_cast<double>(rays.size());
  ask_in_turn(state, rays, ask);
}

}  // namespace

void add_worlds(const Workload& w) {
  benchmark::RegisterBenchmark("stage/box_tree", box_tree)->Arg(100)->Arg(1'000)->Arg(10'000);
  benchmark::RegisterBenchmark("stage/world_collect", [&w](benchmark::State& state) { collect(state, w.shape); })
      ->Arg(100)
      ->Arg(1'000)
      ->Arg(10'000);
  benchmark::RegisterBenchmark("stage/world_sleep", [&w](benchmark::State& state) { sleep(state, w.shape); })
      ->Arg(100)
      ->Arg(1'000)
      ->Arg(10'000)
      ->Arg(100'000);
  benchmark::RegisterBenchmark("stage/world_rollback", [&w](benchmark::State& state) { rollback(state, w.shape); })
      ->Arg(1'000)
      ->Arg(10'000);
  if (w.shape->simple().fine.empty()) return;
  const auto add_rays = [&w](const char* name, RayCaster caster) {
    benchmark::RegisterBenchmark(name, [&w, caster](benchmark::State& state) { world_rays(state, w.shape, caster); })
        ->Arg(100)
        ->Arg(1'000);
  };
  add_rays("stage/world_rays/tree", RayCaster::tree);
  add_rays("stage/world_rays/changed", RayCaster::changed);
  add_rays("stage/world_rays/every_body", RayCaster::every_body);
}

}  // namespace encage::micro
