// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/workload.h"

#include "bench/common/process.h"
#include "bench/common/recorded_poses.h"
#include "broadphase/motion/pair_motion.h"
#include "broadphase/motion/turned_box.h"
#include "broadphase/separation/box_gate.h"
#include "broadphase/separation/surface_pair.h"
#include "broadphase/shape/shape.h"
#include "oracles/meshes.h"

#include <encage/asset.h>
#include <encage/error.h>
#include <encage/poses.h>

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

namespace encage::micro {
namespace {

constexpr std::size_t most_cases = 256;

TriangleMesh in_float(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

CageHierarchy sample_hierarchy() {
  CageHierarchy h;
  h.fine = in_float(shapes::torus(1, 0.35, 128, 32));
  for (const auto& [around, across, thick] :
       {std::tuple{48, 16, 0.365}, std::tuple{32, 12, 0.375}, std::tuple{16, 8, 0.41}}) {
    h.levels.push_back({in_float(shapes::torus(1.01, thick, around, across)), {}});
  }
  h.diagonal = bounds(h.fine).diagonal().norm();
  h.source_volume = signed_volume(h.fine);
  return h;
}

bool boxes_are_apart(const Shape& shape, const Case& c) {
  return boxes_apart(world_box(shape, c.a), world_box(shape, c.b), 0);
}

/// All bodies of both steps, moving from the one to the other.
std::vector<Motion> motions(const PoseStep& from, const PoseStep& to) {
  std::vector<Motion> all;
  for (const BodyPose& body : from.bodies) {
    const BodyPose* end = bench::find_body(to, body.body);
    if (end == nullptr) continue;
    const Motion motion{body.pose, end->pose};
    if (is_usable(motion)) all.push_back(motion);
  }
  return all;
}

}  // namespace

Workload sample_workload() {
  Workload work;
  work.asset = bench::temporary_file("encage-micro.glb");
  work.temporary = {nullptr, [file = work.asset](void*) {
                      std::error_code ignored;
                      std::filesystem::remove(file, ignored);
                    }};
  CageHierarchy hierarchy = sample_hierarchy();
  work.shape = make_shape(hierarchy);
  // The file is there to be loaded; nobody has certified these cages, but a cube that is large enough needs nobody.
  Certificate certificate;
  certificate.clearance = 0.6;
  certificate.volume = 64;
  certificate.components = 1;
  certificate.volume_ratio = certificate.volume / hierarchy.source_volume;
  hierarchy.levels = {{shapes::cube(2), certificate}};
  write_asset(work.asset, hierarchy);
  shapes::Random random(1);
  const auto direction = [&] { return random.point(1).normalized(); };
  const auto motion = [&](const Eigen::Vector3d& at) {
    Motion m;
    m.start.linear() = Eigen::AngleAxisd(random(-3, 3), direction()).toRotationMatrix();
    m.start.translation() = at;
    m.end = m.start;
    m.end.linear() = Eigen::AngleAxisd(random(-0.05, 0.05), direction()) * m.start.linear();
    m.end.translation() += random.point(0.02);
    return m;
  };
  while (work.cases.size() < most_cases) {
    const Case c{motion(random.point(1)), motion(random.point(1) + direction() * random(1, 2.5))};
    work.bodies.insert(work.bodies.end(), {c.a, c.b});
    if (!boxes_are_apart(*work.shape, c)) work.cases.push_back(c);
  }
  return work;
}

Workload recorded_workload(const std::filesystem::path& asset, const std::filesystem::path& poses) {
  constexpr std::size_t most_steps = 64;
  Workload work;
  work.asset = asset;
  work.shape = load_shape(asset);
  const std::vector<PoseStep> steps = read_poses(poses);
  if (steps.size() < 2) throw Error(poses.string() + ": needs two steps or more");
  const std::size_t every = std::max<std::size_t>(1, (steps.size() - 1) / most_steps);
  std::vector<Case> all;
  for (std::size_t s = 0; s + 1 < steps.size(); s += every) {
    const std::vector<Motion> moving = motions(steps[s], steps[s + 1]);
    work.bodies.insert(work.bodies.end(), moving.begin(), moving.end());
    for (std::size_t i = 0; i < moving.size(); ++i) {
      for (std::size_t j = i + 1; j < moving.size(); ++j) {
        if (!boxes_are_apart(*work.shape, {moving[i], moving[j]})) all.push_back({moving[i], moving[j]});
      }
    }
  }
  if (all.empty()) throw Error(poses.string() + ": no two bodies come near each other");
  // Spread evenly.
  const std::size_t count = std::min(all.size(), most_cases);
  for (std::size_t i = 0; i < count; ++i) work.cases.push_back(all[i * all.size() / count]);
  return work;
}

std::vector<TrianglePairCase> near_triangles(const Workload& workload) {
  constexpr int most_leaves = 64;  // of a case
  struct LeafPairs {
    const Surface& surface;
    const PairMotion& motion;
    std::vector<TrianglePairCase>& found;
    int left = most_leaves;
  };
  std::vector<TrianglePairCase> found;
  const Surface& fine = workload.shape->simple().fine;
  for (const Case& c : workload.cases) {
    const LocalFrame& frame = workload.shape->simple().frame;
    const PairMotion motion = pair_motion(frame, c.a, frame, c.b);
    const double distance = required_distance(frame, c.a, frame, c.b, 0);
    const GateBody body{fine.radius, fine.tree.grid};
    LeafPairs context{fine, motion, found};
    visit_leaf_pairs(
        fine.tree, fine.tree, BoxGate(motion, body, body, distance),
        [](void* p, std::int32_t first_a, std::int32_t, std::int32_t first_b, std::int32_t) {
          auto& [surface, m, all, left] = *static_cast<LeafPairs*>(p);
          all.push_back({moving_triangle(surface, m.a, surface.tree.leaves[first_a]),
                         moving_triangle(surface, m.b, surface.tree.leaves[first_b])});
          return --left > 0;
        },
        &context);
  }
  return found;
}

}  // namespace encage::micro
