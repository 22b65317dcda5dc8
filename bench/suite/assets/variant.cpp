// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/assets/variant.h"

#include <algorithm>
#include <cmath>

namespace encage::assets {
namespace {

Eigen::Vector3d transform(const Eigen::Vector3d& x, const Variant& variant) {
  Eigen::Vector3d y;
  for (int k = 0; k < 3; ++k) y[k] = std::ldexp(variant.sign[k] * x[variant.axis[k]], variant.exponent);
  return y;
}

}  // namespace

bool Variant::mirrors() const {
  const int inversions = (axis[0] > axis[1] ? 1 : 0) + (axis[1] > axis[2] ? 1 : 0) + (axis[0] > axis[2] ? 1 : 0);
  return (inversions % 2 != 0) != (sign[0] * sign[1] * sign[2] < 0);
}

Variant make_variant(int number) {
  Variant variant;
  for (int k = number % 6; k > 0; --k) std::next_permutation(variant.axis.begin(), variant.axis.end());
  for (int k = 0; k < 3; ++k) variant.sign[k] = (number / 6 >> k & 1) != 0 ? -1 : 1;
  variant.exponent = -(number / 48);
  return variant;
}

TriangleMesh transform(const TriangleMesh& mesh, const Variant& variant) {
  TriangleMesh result = mesh;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    result.vertices.row(v) = transform(mesh.vertices.row(v).transpose().eval(), variant).transpose();
  }
  if (variant.mirrors()) result.triangles.col(1).swap(result.triangles.col(2));
  return result;
}

CageHierarchy transform(const CageHierarchy& hierarchy, const Variant& variant, const Hash& source_hash) {
  const int e = variant.exponent;
  CageHierarchy result = hierarchy;
  result.source_hash = source_hash;
  result.origin = transform(hierarchy.origin, variant);
  result.source_volume = std::ldexp(hierarchy.source_volume, 3 * e);
  result.diagonal = std::ldexp(hierarchy.diagonal, e);
  result.fine_error = std::ldexp(hierarchy.fine_error, e);
  result.fine = transform(hierarchy.fine, variant);
  for (CageLevel& level : result.levels) {
    level.mesh = transform(level.mesh, variant);
    level.certificate.clearance = std::ldexp(level.certificate.clearance, e);
    level.certificate.volume = std::ldexp(level.certificate.volume, 3 * e);
    // Their bounds depend on the order of the axes.
    level.certificate.max_distance.reset();
    level.certificate.mean_distance.reset();
  }
  return result;
}

}  // namespace encage::assets
