// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/threads/steps.h"

#include "bench/common/clock.h"

#include <algorithm>

namespace encage::threads {
namespace {

/// From one copy of all bodies to the next, along x.
double spacing(const std::vector<PoseStep>& recorded, const Shape& shape) {
  Eigen::AlignedBox3d all;
  for (const PoseStep& step : recorded) {
    for (const BodyPose& body : step.bodies) all.extend(body.pose.translation());
  }
  const Eigen::AlignedBox3d box = world_box(shape, {});
  const double reach = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
  return all.sizes().x() + 4 * reach;
}

}  // namespace

std::vector<WorldStep> make_steps(const std::vector<PoseStep>& recorded, const Shape& shape,
                                  const StepsOptions& options) {
  std::size_t most = 0;
  for (const PoseStep& step : recorded) most = std::max(most, step.bodies.size());
  std::vector<const PoseStep*> full;
  for (const PoseStep& step : recorded) {
    if (step.bodies.size() == most) full.push_back(&step);
  }
  const double offset = options.copies > 1 ? spacing(recorded, shape) : 0;
  std::vector<WorldStep> steps;
  for (std::size_t i = 0; i < full.size(); i += static_cast<std::size_t>(options.every)) {
    const PoseStep& now = *full[i];
    const PoseStep& next = options.continuous && i + 1 < full.size() ? *full[i + 1] : now;
    WorldStep& step = steps.emplace_back();
    for (int copy = 0; copy < options.copies; ++copy) {
      const Eigen::Translation3d shift(offset * copy, 0, 0);
      for (std::size_t b = 0; b < most; ++b) step.push_back({shift * now.bodies[b].pose, shift * next.bodies[b].pose});
    }
  }
  return steps;
}

Walker::Walker(ShapePtr shape, const WorldStep& first, CandidateOptions options) : options_(std::move(options)) {
  const ShapeId id = world_.add_shape(std::move(shape));
  for (const Motion& motion : first) bodies_.push_back(world_.add_body(id, motion.start));
}

void Walker::move(const WorldStep& step) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) world_.set_motion(bodies_[b], step[b]);
}

StepTime Walker::walk(const WorldStep& step) {
  const bench::Stopwatch watch;
  move(step);
  const double update = watch.milliseconds();
  std::size_t triangles = 0;
  world_.find_candidates(options_, [&](const CandidatePair& pair) { triangles += pair.triangles.size(); });
  return {update, watch.milliseconds() - update};
}

SearchResult Walker::walk_and_tell(const WorldStep& step) {
  move(step);
  SearchResult answer;
  const CandidateStatistics s = world_.find_candidates(options_, [&](const CandidatePair& pair) {
    SearchResult::Found found{pair.a, pair.b, pair.verdict.stage, pair.verdict.level, {}};
    for (const TrianglePair t : pair.triangles) found.triangles.emplace_back(t.a, t.b);
    answer.found.push_back(std::move(found));
  });
  answer.counts = {s.overlapping, s.refused, s.separated[0], s.separated[1], s.separated[2], s.candidates, s.asked};
  return answer;
}

}  // namespace encage::threads
