// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/shape.h>

#include <cstdint>
#include <vector>

namespace encage::bench {

/// A body during one step: from the pose in which the step before left it to the pose that it would have at the end if
/// nothing were in its way.
struct RecordedBody {
  std::int32_t body = 0;
  Motion motion;
};

/// What collision detection is asked in one step: the bodies by increasing number.
struct RecordedStep {
  std::int64_t step = 0;
  std::vector<RecordedBody> bodies;
};

/// A simulation, recorded once; every strategy answers the same steps.
struct Recording {
  double dt = 0;  ///< seconds between two steps
  std::vector<RecordedStep> steps;
};

}  // namespace encage::bench
