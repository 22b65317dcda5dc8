// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/collapse/cage_editor.h"

#include <cstdint>
#include <functional>

namespace encage::makers {

struct CollapseLimits {
  std::int64_t faces = 0;                         ///< stop at this many or fewer
  double added_volume = 0;                        ///< give up when the cage has grown by more
  std::uint64_t work = 0;                         ///< give up after so many triangle tests
  std::function<void(double fraction)> progress;  ///< may throw to cancel
};

/// Merges edges, cheapest first, until the limit of faces is reached (true) or nothing more can be merged, the volume
/// explodes or the work is spent (false).
bool collapse_edges(CageEditor& cage, const CollapseLimits& limits);

/// Moves every vertex once, in order, to where the cage encloses least. Returns the volume gained.
double tighten(CageEditor& cage);

}  // namespace encage::makers
