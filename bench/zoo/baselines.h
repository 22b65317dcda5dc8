// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace encage::zoo {

/// What a plain method made of one mesh, as in figures 4 and 5 of Nested Cages (Sacht et al. 2015).
struct BaselineResult {
  std::string name;  ///< "alpha wrap", "progressive hull", "offset contour"
  std::optional<double>
      volume_ratio;  ///< volume of the cage / of the source; none without a cage, or for an open source
  bool certified = false;
  std::int64_t faces = 0;
  std::int64_t hits = 0;       ///< triangles of the cage that touch the source, exactly
  std::int64_t self_hits = 0;  ///< triangles of the cage that intersect another one of it, exactly
  double cpu_seconds = 0;      ///< of the search for the parameter as well; without the certificates of the result
  std::string error;           ///< why there is no cage, or why its certificate was refused
};

/// CGAL's alpha wrap with the smallest alpha that gives at most `faces` triangles; the offset is alpha / 12.
BaselineResult single_alpha_wrap(const SourceMesh& source, std::int64_t faces);

/// Sander et al. 2000, "Silhouette clipping", section 3: edges collapse to the point outside of all planes around them
/// that adds the least volume. Nothing else is tested. Needs a closed manifold.
BaselineResult progressive_hull(const SourceMesh& source, std::int64_t faces);

/// Contours of the distance from the source, decimated by edge collapse (Lindstrom and Turk) and freed of
/// self-intersection: the one at the smallest distance that holds. If none does, the last one that was tried.
BaselineResult offset_contour(const SourceMesh& source, std::int64_t faces);

struct PlainMethod {
  const char* name;  ///< as BaselineResult::name
  BaselineResult (*run)(const SourceMesh& source, std::int64_t faces);
};

/// The three above, in this order.
std::span<const PlainMethod> baselines();

/// All of them. One thread; no exception but for a lack of memory.
std::vector<BaselineResult> run_baselines(const SourceMesh& source, std::int64_t faces);

}  // namespace encage::zoo
