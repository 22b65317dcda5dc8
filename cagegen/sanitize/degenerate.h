// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>

namespace encage::io {

/// Degenerate triangles that hang on to the surface by at most two of their edges (spikes, stray segments) bound
/// nothing: rewrites them as the same segment or point with a repeated vertex (a, b, b), so that is_closed() passes
/// over them.
void mark_dangling(TriangleMesh& mesh);

/// The surface without degenerate triangles. Where one (a, b, c) fills a seam between two valid triangles its longest
/// edge is flipped, which leaves the point set as it is. Elsewhere it becomes thin valid triangles through an added
/// vertex, `thickness` beside the segment, which contain the segment and keep what was closed closed. Those with a
/// repeated vertex are dropped if an edge of a valid triangle covers them. Returns how many triangles were degenerate.
std::int64_t replace_degenerate(TriangleMesh& mesh, double thickness);

}  // namespace encage::io
