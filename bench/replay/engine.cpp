// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/engine.h"

#include <algorithm>

namespace encage::replay {

bool StepQuestion::leaves_out(const BodyPose& a, const BodyPose& b) const {
  return not_asked_for != nullptr &&
         std::binary_search(not_asked_for->begin(), not_asked_for->end(), make_pair(a.body, b.body));
}

}  // namespace encage::replay
