// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/benches.h"
#include "broadphase/motion/pair_motion.h"
#include "broadphase/separation/containment.h"
#include "broadphase/separation/leaf_gate.h"
#include "broadphase/shape/shape.h"
#include "oracles/meshes.h"

#include <encage/contact.h>

#include <deque>
#include <string>
#include <vector>

namespace encage::micro {
namespace {

/// What the rounding of tests of triangles near the origin needs.
constexpr double distance = 1e-12;

MovingPoints vertex_and_face(const TrianglePairCase& t) {
  return {{t.a.start[0], t.b.start[0], t.b.start[1], t.b.start[2]}, {t.a.end[0], t.b.end[0], t.b.end[1], t.b.end[2]}};
}

MovingPoints two_edges(const TrianglePairCase& t) {
  return {{t.a.start[0], t.a.start[1], t.b.start[0], t.b.start[1]}, {t.a.end[0], t.a.end[1], t.b.end[0], t.b.end[1]}};
}

struct LocalPoint {
  const Surface* surface;
  Eigen::Vector3d point;
};

/// Anywhere in the box of the surface.
std::vector<LocalPoint> points_in_box(const Surface& surface) {
  shapes::Random random(2);
  std::vector<LocalPoint> points;
  const Eigen::Vector3d low = surface.lower.cast<double>(), size = surface.upper.cast<double>() - low;
  for (int i = 0; i < 512; ++i) {
    points.push_back({&surface, low + size.cwiseProduct((random.point(0.5).array() + 0.5).matrix())});
  }
  return points;
}

void add_points(const std::string& level, const Surface& surface, const Workload& w) {
  if (surface.empty()) return;
  static std::deque<std::vector<LocalPoint>> kept;  // as long as the workload
  const std::vector<LocalPoint>& points = kept.emplace_back(points_in_box(surface));
  add("kernel/locate/" + level, points, [](const LocalPoint& p) { return locate(*p.surface, p.point); });
  add("kernel/all_outside/" + level, w.cases, [&](const Case& c) {
    return all_outside(surface, surface,
                       relative_frame(w.shape->simple().frame, c.a.start, w.shape->simple().frame, c.b.start));
  });
}

struct LanesCase {
  LeafLanes a, b;
};

/// A triangle of one pair against those of as many pairs as there are lanes.
std::vector<LanesCase> side_by_side(const std::vector<TrianglePairCase>& triangles) {
  std::vector<LanesCase> cases(triangles.size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (int lane = 0; lane < LeafLanes::width; ++lane) {
      cases[i].a.set(lane, triangles[i].a, 2);
      cases[i].b.set(lane, triangles[(i + static_cast<std::size_t>(lane)) % cases.size()].b, 2);
    }
  }
  return cases;
}

}  // namespace

void add_kernels(const Workload& w) {
  static const std::vector<TrianglePairCase> triangles = near_triangles(w);
  add("kernel/triangles_apart/rest", triangles,
      [](const TrianglePairCase& t) { return triangles_apart(t.a.start, t.b.start, distance); });
  static const std::vector<LanesCase> lanes = side_by_side(triangles);
  for (const int ends : {1, 2}) {
    add(ends == 1 ? "kernel/lanes_apart/rest" : "kernel/lanes_apart/moving", lanes,
        [ends](const LanesCase& c) { return lanes_not_apart(c.a, 0, c.b, LeafLanes::width, ends, distance); });
  }
  add("kernel/triangles_apart/moving_full", triangles,
      [](const TrianglePairCase& t) { return moving_triangles_apart(t.a, t.b, distance); });
  add("kernel/vertex_face_time", triangles,
      [](const TrianglePairCase& t) { return vertex_face_time(vertex_and_face(t)); });
  add("kernel/edge_edge_time", triangles, [](const TrianglePairCase& t) { return edge_edge_time(two_edges(t)); });
  for (std::size_t k = 0; k < w.shape->simple().cages.size(); ++k)
    add_points("cage_" + std::to_string(k), w.shape->simple().cages[k], w);
  add_points("fine", w.shape->simple().fine, w);
}

}  // namespace encage::micro
