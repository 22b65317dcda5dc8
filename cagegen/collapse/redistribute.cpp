// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/redistribute.h"

#include "cagegen/collapse/collapse.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

// Decided by experiment on six models at 500 and 100 faces.
constexpr double first_share = 0.2;  // faces added in a round, of those of the cage
constexpr double split_reach = 0.3;  // edge lengths by which the new vertex may move
constexpr int steps_between = 8;     // of the minimisation, before merging
constexpr int steps_after = 15;      // and after
constexpr double merge_quadric_weight = 1;

struct Split {
  double gain;
  std::int32_t u, v;
  double reach;
};

std::vector<Split> splits_by_gain(CageEditor& cage) {
  std::vector<Split> splits;
  std::vector<std::int32_t> neighbours;
  for (std::int32_t u = 0; u < cage.vertex_capacity(); ++u) {
    if (!cage.alive(u)) continue;
    cage.neighbours(u, neighbours);
    for (const std::int32_t v : neighbours) {
      if (v < u) continue;
      const double reach = split_reach * (cage.position(u) - cage.position(v)).norm();
      if (const auto plan = cage.plan_split(u, v, reach)) splits.push_back({-plan->cost, u, v, reach});
    }
  }
  std::sort(splits.begin(), splits.end(),
            [](const Split& a, const Split& b) { return std::tie(b.gain, a.u, a.v) < std::tie(a.gain, b.u, b.v); });
  return splits;
}

void split_edges(CageEditor& cage, std::int64_t faces) {
  for (const Split& split : splits_by_gain(cage)) {
    if (cage.face_count() + 2 > faces) return;
    // What was split before may have changed its triangles.
    if (const auto plan = cage.plan_split(split.u, split.v, split.reach)) {
      cage.apply_split(split.u, split.v, plan->position);
    }
  }
}

TriangleMesh refined(const Obstacle& obstacle, const TriangleMesh& cage, const RedistributeRequest& request,
                     std::int64_t faces) {
  CageEditor editor(obstacle, cage, request.editing);
  split_edges(editor, faces);
  for (int pass = 0; pass < 2; ++pass) tighten(editor);
  return editor.extract();
}

TriangleMesh merged(const Obstacle& obstacle, const TriangleMesh& cage, const RedistributeRequest& request) {
  EditorOptions options = request.editing;
  options.quadric_weight = merge_quadric_weight;
  CageEditor editor(obstacle, cage, options);
  CollapseLimits limits;
  limits.faces = request.faces;
  limits.progress = [&](double) { request.contact.check(); };
  collapse_edges(editor, limits);
  for (int pass = 0; pass < 2; ++pass) tighten(editor);
  return editor.extract();
}

}  // namespace

TriangleMesh redistribute_faces(const Obstacle& obstacle, const TriangleMesh& cage,
                                const RedistributeRequest& request) {
  const std::uint64_t last_work = Obstacle::work() + request.work;
  TriangleMesh best = cage;
  double volume = signed_volume(cage);
  double share = first_share;
  int idle = 0;
  for (int round = 0; round < request.rounds && idle < request.patience && Obstacle::work() < last_work; ++round) {
    const auto more = static_cast<std::int64_t>(share * static_cast<double>(request.faces));
    TriangleMesh next = refined(obstacle, best, request, request.faces + std::max<std::int64_t>(more, 4));
    next = shrink(obstacle, next, request.contact, steps_between);
    next = merged(obstacle, next, request);
    next = shrink(obstacle, next, request.contact, steps_after);
    const double next_volume = signed_volume(next);
    idle = next_volume < volume - request.enough ? 0 : idle + 1;
    if (next_volume < volume && next.triangles.rows() <= request.faces) {
      best = std::move(next);
      volume = next_volume;
    } else {
      share /= 2;
    }
  }
  return best;
}

}  // namespace encage::makers
