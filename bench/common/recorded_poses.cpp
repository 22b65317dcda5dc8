// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/recorded_poses.h"

#include "src/files/hash.h"

#include <encage/error.h>

#include <algorithm>
#include <array>
#include <span>

namespace encage::bench {
namespace {

RecordedStep step_between(const PoseStep& from, const PoseStep& to, const std::string& file) {
  RecordedStep step{from.step, {}};
  for (const BodyPose& start : from.bodies) {
    const BodyPose* end = find_body(to, start.body);
    if (end == nullptr) continue;
    const Motion motion{start.pose, end->pose};
    if (!is_usable(motion)) {
      throw Error(file + ": step " + std::to_string(from.step) + ", body " + std::to_string(start.body) +
                  ": turns by 180 degrees or more until the next step");
    }
    step.bodies.push_back({start.body, motion});
  }
  return step;
}

}  // namespace

const BodyPose* find_body(const PoseStep& step, std::int32_t body) {
  const auto at = std::lower_bound(step.bodies.begin(), step.bodies.end(), body,
                                   [](const BodyPose& pose, std::int32_t number) { return pose.body < number; });
  return at != step.bodies.end() && at->body == body ? &*at : nullptr;
}

Recording recording_of(const std::vector<PoseStep>& poses, double dt, std::int64_t every, const std::string& file) {
  if (poses.size() < 2) throw Error(file + ": needs two steps or more");
  Recording recording{dt, {}};
  for (std::size_t i = 0; i + 1 < poses.size(); i += static_cast<std::size_t>(every)) {
    recording.steps.push_back(step_between(poses[i], poses[i + 1], file));
  }
  return recording;
}

Hash trajectory_hash(const std::vector<PoseStep>& poses) {
  Hasher hasher;
  for (const PoseStep& step : poses) {
    for (const BodyPose& body : step.bodies) {
      std::array<double, 12> values;
      for (int k = 0; k < 12; ++k) values[k] = body.pose.matrix()(k % 3, k / 3);
      hasher.add(std::as_bytes(std::span(values)));
    }
  }
  return hasher.digest();
}

}  // namespace encage::bench
