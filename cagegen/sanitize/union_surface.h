// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <functional>
#include <optional>

namespace encage::io {

/// The boundary of the union of a mesh's parts where they overlap, touch or contain each other. A part is what hangs
/// together by edges of two triangles. Decimations should begin with that boundary: that of the parts intersects
/// itself. Intersections are exact, then rounded to double. No value if the parts are apart, if one of them is not a
/// solid by itself, if the union is not a manifold, or for more than a hundred parts or 100,000 triangles, where it
/// would take long. `mesh` has no degenerate triangles. `check` is called between parts, and may throw.
std::optional<TriangleMesh> union_surface(const TriangleMesh& mesh, const std::function<void()>& check);

}  // namespace encage::io
