// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

namespace encage::zoo {

/// True for a closed 2-manifold, consistently oriented, without self-intersection: the inputs that tightness is
/// measured on. Exact.
bool is_clean(const TriangleMesh& mesh);

}  // namespace encage::zoo
