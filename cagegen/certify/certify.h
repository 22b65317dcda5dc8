// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

namespace encage {

/// Proves what concerns the cage alone: that it is closed, oriented and embedded. Clearance and no_new_handles are left
/// unset.
CertifyResult certify_alone(const TriangleMesh& cage);

}  // namespace encage
