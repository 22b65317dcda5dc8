// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/compare.h"

namespace encage::tank {

/// Judges contacts by exact arithmetic on world coordinates rounded to double. Features that come within 2^-44 of the
/// coordinates' size count as touching: closer than that, which rounding was whose cannot be told. With a margin or an
/// arc, by subdivision instead. `body` has to outlive the judge.
Judge exact_judge(const TankBody& body, const ContactOptions& options);

}  // namespace encage::tank
