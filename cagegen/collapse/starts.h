// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/obstacle.h"

#include <encage/mesh.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace encage::makers {

// Closed surfaces around an obstacle from which a collapse can begin. Vertices are exactly representable in float32. No
// value if the attempt failed.

/// A surface moved outward by `height`; needs a closed oriented manifold. Where it touches something, vertices are
/// moved less if the surface is the obstacle's own (`grow` false). If it only resembles the obstacle (`grow` true),
/// they are moved more, and folds are smoothed away.
std::optional<TriangleMesh> offset_start(const Obstacle& obstacle, const TriangleMesh& surface, double height,
                                         bool grow, double clearance);

/// Pulls apart what meets at non-manifold edges and vertices, and drops pairs of opposite triangles and unused
/// vertices. The parts still touch there.
TriangleMesh make_manifold(const TriangleMesh& mesh);

/// A plain decimation to about `faces`, manifold but not clear of anything; by meshoptimizer.
TriangleMesh simplify(const TriangleMesh& mesh, std::int64_t faces);

/// The outermost surfaces of CGAL's alpha wrap of a mesh without degenerate triangles; alpha and offset are lengths.
TriangleMesh alpha_wrap(const TriangleMesh& clean, double alpha, double offset);

/// The offset of an alpha wrap, of its alpha.
constexpr double wrap_offset = 1.0 / 12;

/// An alpha wrap that is clear of the obstacle.
std::optional<TriangleMesh> wrap_start(const Obstacle& obstacle, const TriangleMesh& clean, double alpha, double offset,
                                       double clearance);

/// The alpha wraps around one obstacle, each made once and when it is first asked for. Thread-safe.
class WrapStarts {
 public:
  /// `clean` is the obstacle's surface without degenerate triangles. Refers to both.
  WrapStarts(const Obstacle& obstacle, const TriangleMesh& clean, double diagonal, double clearance)
      : obstacle_(obstacle), clean_(clean), diagonal_(diagonal), clearance_(clearance) {}

  /// wrap_start() with an alpha of diagonal / parameter.
  const std::optional<TriangleMesh>& get(double parameter);

 private:
  struct Entry {
    std::once_flag once;
    std::optional<TriangleMesh> start;
  };
  const Obstacle& obstacle_;
  const TriangleMesh& clean_;
  double diagonal_, clearance_;
  std::mutex mutex_;  // guards the map, not its entries
  std::map<double, Entry> entries_;
};

/// The components for which `kept` is set, of a mesh labelled by triangle_components(); unused vertices go.
TriangleMesh keep_components(const TriangleMesh& mesh, std::span<const std::int32_t> label,
                             const std::vector<bool>& kept);

/// Drops every component that lies inside another or bounds a void: what it encloses stays enclosed.
TriangleMesh outermost_components(const TriangleMesh& cage);

/// True if `cage` is clear of the obstacle and of itself by the makers' conservative tests.
bool clear(const Obstacle& obstacle, const TriangleMesh& cage, double clearance);

}  // namespace encage::makers
