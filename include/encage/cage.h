// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>
#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ENCAGE_EXPORT encage {

/// 128-bit hash of some content (XXH3). It detects damage, not malice.
struct Hash {
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  friend bool operator==(const Hash&, const Hash&) = default;
};

std::string to_string(const Hash& hash);  ///< 32 lower-case hexadecimal digits

/// How a cage was made.
enum class Method { collapse, flow, hull };

const char* name(Method method) noexcept;

/// What has been proven about one cage Ci and the next finer level C(i-1), by exact predicates on the float32 vertices
/// that are in the file.
struct Certificate {
  double clearance = 0;  ///< lower bound of the distance between the surfaces Ci and C(i-1): a length > 0
  double volume = 0;     ///< enclosed by Ci, in cubic units, rounded
  /// volume / volume of the source, usually 1.001 to 2. No value if the source is no solid.
  std::optional<double> volume_ratio;
  /// Bounds from above, within some 1 %, of how far Ci is from the source, caps included: lengths. max_distance bounds
  /// every point of Ci, mean_distance their mean over Ci's area. No value in assets from before these figures.
  std::optional<double> max_distance;
  std::optional<double> mean_distance;
  int components = 0;  ///< connected components of the surface, cavities included; usually 1
  int cavities = 0;    ///< components that bound a void inside the cage; usually 0
  int genus = 0;       ///< sum over the components
  /// Condition (ii) of the paper's section 1, tested by counts: Ci has no more handles than C(i-1). No value where
  /// C(i-1) is no closed manifold.
  std::optional<bool> no_new_handles;
  Method method = Method::collapse;
  std::string start;  ///< the start or decimation that won, e.g. "offset", "wrap/50"
};

/// One cage. Its vertices are relative to the hierarchy's origin and exact in float32.
struct CageLevel {
  TriangleMesh mesh;
  Certificate certificate;
};

/// Nested cages around one source, from fine to coarse. The source itself is kept apart from them, as `fine`.
struct CageHierarchy {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< source vertex = origin + local vertex
  Solid solid = Solid::closed;
  Hash source_hash;          ///< of the vertices and triangles as read, in double
  double source_volume = 0;  ///< in cubic units; 0 if the source is no solid
  double diagonal = 0;       ///< of the source's bounding box, a length

  TriangleMesh fine;  ///< the source's triangles, then the caps, in the local frame, exact in float32; may be empty
  /// Triangles that were added to close the source: the last ones of `fine`, if that is kept.
  std::int64_t cap_count = 0;
  /// Upper bound of the distance between a fine vertex and its source vertex, caused by rounding to float32: a length,
  /// usually below 1e-6 diagonals.
  double fine_error = 0;

  std::vector<CageLevel> levels;
  /// The options of the bake, as a compact JSON object with sorted keys (an asset returns this form whatever was
  /// written). May be empty.
  std::string options;
  bool truncated = false;  ///< a time limit cut the work short
};

}  // namespace encage
