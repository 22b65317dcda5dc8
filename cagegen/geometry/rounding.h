// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include "cagegen/geometry/separation.h"

namespace encage::makers {

/// The nearest point with float32 coordinates, which is what an asset stores.
Point round_to_float(const Point& p);

void round_vertices(TriangleMesh& mesh);

}  // namespace encage::makers
