// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

namespace encage {

/// The part of certify() that concerns the cage alone: closed, oriented, embedded. Clearance and no_new_handles are
/// left unset.
CertifyResult certify_alone(const TriangleMesh& cage);

}  // namespace encage
