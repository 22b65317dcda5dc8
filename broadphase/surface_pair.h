// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/frame.h"

namespace encage {

/// True only if every triangle of `a` is proven farther than `distance` > 0 from
/// every triangle of `b`, both as computed in the frame of a. `distance` has to
/// cover rounding: required_distance(). Stops at the first pair without proof.
bool surfaces_apart(const Surface& a, const Surface& b, const PairFrame& frame, double distance) noexcept;

}  // namespace encage
