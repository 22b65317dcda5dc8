// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/continuous.h"

#include "bench/common/box_pairs.h"
#include "bench/common/step_times.h"

#include <encage/contact.h>

#include <algorithm>

namespace encage::replay {
namespace {

struct PairCounts {
  std::int64_t left_out = 0, asked = 0, survivors = 0, contacts = 0;
};

/// A body's motion in a step, or its pose at the start.
Motion motion_of(const bench::RecordedBody& body, bool moving) {
  return moving ? body.motion : Motion::resting(body.motion.start);
}

class PairDetector {
 public:
  explicit PairDetector(const Shape& shape) : shape_(shape) {
    options_.boxes = false;
    options_.cages = CageUse::never;
  }

  PairCounts run(const bench::RecordedStep& step, const std::vector<BodyPair>& leave_out, bool moving) {
    motions_.clear();
    for (const bench::RecordedBody& body : step.bodies) motions_.push_back(motion_of(body, moving));
    PairCounts counts;
    for (const auto& [i, j] : boxes_.overlaps(shape_, motions_)) {
      const BodyPair pair = make_pair(step.bodies[i].body, step.bodies[j].body);
      if (std::binary_search(leave_out.begin(), leave_out.end(), pair)) {
        ++counts.left_out;
        continue;
      }
      ++counts.asked;
      if (separated(shape_, motions_[i], shape_, motions_[j], options_).separated) continue;
      ++counts.survivors;
      if (moving) counts.contacts += first_contact(shape_, motions_[i], shape_, motions_[j]).has_value();
    }
    return counts;
  }

 private:
  const Shape& shape_;
  PairOptions options_;
  bench::BoxPairs boxes_;
  std::vector<Motion> motions_;
};

}  // namespace

Continuous continuous(const Shape& shape, const bench::Recording& recording,
                      const std::vector<std::vector<BodyPair>>& touching, int runs,
                      const std::function<void(double fraction)>& progress) {
  const std::size_t steps = recording.steps.size();
  std::vector<PairCounts> counts(steps);
  bench::StepTimes moving(steps), resting(steps);
  PairDetector detector(shape);
  std::size_t done = 0;
  bench::in_turns(runs, steps, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      counts[i] = moving.time(i, [&] { return detector.run(recording.steps[i], touching[i], true); });
    }
    for (std::size_t i = first; i < last; ++i) {
      resting.time(i, [&] { return detector.run(recording.steps[i], touching[i], false); });
    }
    done += last - first;
    progress(static_cast<double>(done) / static_cast<double>(steps * static_cast<std::size_t>(runs)));
  });
  Continuous result;
  result.steps = static_cast<std::int64_t>(steps);
  for (const PairCounts& c : counts) {
    result.left_out += c.left_out;
    result.asked += c.asked;
    result.survivors += c.survivors;
    result.contacts += c.contacts;
  }
  result.ms_per_step = moving.mean_of_medians();
  result.discrete_ms_per_step = resting.mean_of_medians();
  return result;
}

}  // namespace encage::replay
