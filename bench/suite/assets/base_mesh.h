// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

namespace encage::assets {

/// A star of 6 to 14 arms about 0 with about as many triangles, at least 200, another one for each number; about 1 in
/// radius, vertices exact in float32. The same on every machine.
TriangleMesh make_base_mesh(int number, int triangles);

}  // namespace encage::assets
