// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/cage.h>

#include <array>

namespace encage::assets {

/// One of the 48 symmetries of a cube, followed by a factor 2^exponent: exact in floating point.
struct Variant {
  std::array<int, 3> axis{0, 1, 2};  ///< coordinate k becomes sign[k] times the coordinate axis[k]
  std::array<int, 3> sign{1, 1, 1};
  int exponent = 0;

  bool mirrors() const;
};

/// Number 0 to 47: a symmetry each; the next 48 with a factor of 1/2, then 1/4.
Variant make_variant(int number);

TriangleMesh transform(const TriangleMesh& mesh, const Variant& variant);

/// The hierarchy of the transformed source, with certificates as true as they were: an exact map keeps nesting, and
/// scales clearances and volumes exactly. `source_hash` is that of the transformed source.
CageHierarchy transform(const CageHierarchy& hierarchy, const Variant& variant, const Hash& source_hash);

}  // namespace encage::assets
