// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>

namespace encage::stress {

/// How well a closed surface's triangles are shaped. Angles in degrees.
struct Quality {
  double smallest_angle = 0;  ///< of all triangles
  double low_angle = 0;       ///< a twentieth of the triangles have a smaller smallest angle
  int highest_valence = 0;    ///< edges around a vertex
  std::int64_t folds = 0;     ///< edges whose interior angle is below 20 degrees: the ridges of tents
};

Quality quality(const TriangleMesh& mesh);

}  // namespace encage::stress
