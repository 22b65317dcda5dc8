// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/pair_lists.h"

#include "bench/replay/box_pairs.h"

#include <encage/error.h>

#include <algorithm>

namespace encage::covers {
namespace {

std::vector<Motion> resting(const PoseStep& step) {
  std::vector<Motion> motions;
  for (const BodyPose& body : step.bodies) motions.push_back(Motion::resting(body.pose));
  return motions;
}

std::vector<Motion> moving(const PoseStep& step, const PoseStep& next) {
  std::vector<Motion> motions;
  for (const BodyPose& body : step.bodies) {
    const auto at = std::lower_bound(next.bodies.begin(), next.bodies.end(), body.body,
                                     [](const BodyPose& b, std::int32_t number) { return b.body < number; });
    if (at == next.bodies.end() || at->body != body.body) continue;
    const Motion motion{body.pose, at->pose};
    if (is_usable(motion)) motions.push_back(motion);
  }
  return motions;
}

}  // namespace

PairLists make_pairs(const Shape& shape, const std::vector<PoseStep>& poses, std::int64_t every, bool move) {
  PairLists lists;
  replay::BoxPairs boxes;
  const std::size_t end = move && !poses.empty() ? poses.size() - 1 : poses.size();
  for (std::size_t s = 0; s < end; s += static_cast<std::size_t>(every)) {
    const std::vector<Motion> motions = move ? moving(poses[s], poses[s + 1]) : resting(poses[s]);
    std::vector<PairCase>& list = lists.emplace_back();
    for (const auto& [i, j] : boxes.overlaps(shape, motions)) {
      list.push_back({pair_motion(shape, motions[i], shape, motions[j]),
                      required_distance(shape, motions[i], shape, motions[j], 0)});
    }
  }
  if (lists.empty()) throw Error(move ? "the poses are fewer than two steps" : "there are no poses");
  return lists;
}

}  // namespace encage::covers
