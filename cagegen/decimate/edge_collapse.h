// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/decimate/decimate.h"

#include <encage/mesh.h>

#include <cstdint>
#include <functional>
#include <optional>

namespace encage::makers {

/// CGAL's edge collapse down to `faces` triangles, or until no edge is left that may be collapsed. With a gap, none is
/// that would bring triangles into contact, as self_contacts() defines it. `check` is called often and may throw.
/// Throws Error if the mesh is not a closed oriented manifold. One run, the same bytes as the next.
TriangleMesh collapse_edges(const TriangleMesh& mesh, std::int64_t faces, Decimation kind, std::optional<double> gap,
                            const std::function<void()>& check);

}  // namespace encage::makers
