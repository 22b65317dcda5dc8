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

/// 128-bit content hash (XXH3). Detects damage, not malice.
struct Hash {
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  friend bool operator==(const Hash&, const Hash&) = default;
};

std::string to_string(const Hash& hash);  ///< 32 lower-case hexadecimal digits

/// How a cage was made.
enum class Method { collapse, flow, hull };

const char* name(Method method) noexcept;

/// What has been proven about one cage Ci with respect to the next finer level
/// C(i-1), by exact predicates on the float32 vertices that are in the file.
struct Certificate {
  double clearance = 0;  ///< lower bound of the distance between the surfaces Ci and C(i-1), > 0
  double volume = 0;     ///< enclosed volume of Ci, cubic units
  /// volume / volume of the source; no value if the source is no solid.
  std::optional<double> volume_ratio;
  int components = 0;  ///< connected surface components, cavities included
  int cavities = 0;    ///< components that bound a void inside the cage
  int genus = 0;       ///< sum over the components
  /// Paper section 1, condition (ii), tested by counts: no more handles in Ci
  /// than in C(i-1). No value where C(i-1) is no closed manifold.
  std::optional<bool> no_new_handles;
  Method method = Method::collapse;
  std::string start;  ///< which start or decimation won, e.g. "offset", "wrap/50"
};

/// One cage. Vertices are exactly representable in float32, relative to the
/// hierarchy's origin.
struct CageLevel {
  TriangleMesh mesh;
  Certificate certificate;
};

/// Nested cages around one source, fine to coarse. Level 0, the source, is held
/// apart: `fine` is its float32 rendition (may be empty).
struct CageHierarchy {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< source vertex = origin + local vertex
  Solid solid = Solid::closed;
  Hash source_hash;          ///< of the vertices and triangles as read, in double
  double source_volume = 0;  ///< 0 if the source is no solid
  double diagonal = 0;       ///< of the source's bounds

  TriangleMesh fine;  ///< local frame; source triangles, then caps; vertices exact in float32
  /// Triangles added to close the source; the last ones of `fine` where that is kept.
  std::int64_t cap_count = 0;
  /// Upper bound of |fine vertex - source vertex| caused by rounding to float32.
  double fine_error = 0;

  std::vector<CageLevel> levels;
  /// The bake options, a JSON object, compact and with sorted keys (an asset
  /// returns it in that form whatever was written); may be empty.
  std::string options;
  bool truncated = false;  ///< a time limit cut the work short
};

}  // namespace encage
