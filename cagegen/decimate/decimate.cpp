// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/decimate.h"

#include "cagegen/decimate/edge_collapse.h"

#include <encage/decimator.h>
#include <encage/error.h>

#include <string>

namespace encage::makers {

namespace {

// Distance that the public decimators keep between strands, in diagonals. The flow works best with the first; a dense
// mesh may have edges about as short.
constexpr double gap_factor[] = {1e-4, 1e-5};

struct Attempt {
  std::optional<TriangleMesh> mesh;
  std::int64_t reached = 0;  ///< triangles where the collapse ended, wanted or not
};

/// At most `limit` triangles, and `faces` if it can be.
Attempt attempt(const TriangleMesh& mesh, std::int64_t faces, std::int64_t limit, Decimation kind, double gap,
                const std::function<void()>& check) {
  Attempt result;
  for (const auto guard : {std::optional<double>(), std::optional<double>(gap)}) {
    const TriangleMesh coarse = collapse_edges(mesh, faces, kind, guard, check);
    if (!guard) result.reached = coarse.triangles.rows();
    if (coarse.triangles.rows() > limit) break;
    result.mesh = untangle(coarse, gap);
    if (result.mesh) break;
  }
  return result;
}

TriangleMesh decimate_or_throw(const TriangleMesh& mesh, std::int64_t faces, Decimation kind) {
  const std::string what = "decimation to " + std::to_string(faces) + " faces: ";
  if (faces < 4) throw Error(what + "a closed mesh has at least 4");
  const double diagonal = bounds(mesh).diagonal().norm();
  for (const double gap : gap_factor) {
    Attempt result = attempt(mesh, faces, faces, kind, gap * diagonal, [] {});
    if (result.mesh) return std::move(*result.mesh);
    if (result.reached > faces) {
      throw Error(what + "no edge of " + std::to_string(result.reached) + " faces can be collapsed any more");
    }
  }
  throw Error(what + "the result intersects itself");
}

}  // namespace

std::optional<TriangleMesh> decimate(const TriangleMesh& mesh, std::int64_t faces, Decimation kind, double gap,
                                     const std::function<void()>& check) {
  return attempt(mesh, faces, faces, kind, gap, check).mesh;
}

}  // namespace encage::makers

namespace encage {

Decimator regular_decimator() {
  return [](const TriangleMesh& finer, const TriangleMesh&, std::int64_t faces) {
    return makers::decimate_or_throw(finer, faces, makers::Decimation::regular);
  };
}

Decimator adaptive_decimator() {
  return [](const TriangleMesh& finer, const TriangleMesh&, std::int64_t faces) {
    return makers::decimate_or_throw(finer, faces, makers::Decimation::adaptive);
  };
}

}  // namespace encage
