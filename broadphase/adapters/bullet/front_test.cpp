// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/front_test.h"

#include "broadphase/adapters/bullet/convert.h"
#include "broadphase/shape.h"

#include <cmath>
#include <limits>

namespace encage::bullet {
namespace {

/// More cost as much as GImpact itself.
constexpr int most_pairs = 4000;

Triangle corners(const AttachedMesh& a, std::int32_t triangle) {
  Triangle result;
  const Surface& fine = a.shape->fine;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto vertex = static_cast<std::int32_t>(fine.mesh.triangles[static_cast<std::size_t>(triangle)][k]);
    result[k] = a.mesh.scale * (a.shape->origin + fine.vertex(vertex));
  }
  return result;
}

}  // namespace

bool lies_in_front(const Triangle& face, const Triangle& other, double margins, double error) noexcept {
  const Eigen::Vector3d e1 = face[1] - face[0], e2 = face[2] - face[0], product = e1.cross(e2);
  const double l1 = e1.norm(), l2 = e2.norm(), area = product.norm();
  // Far from where Bullet's squares leave the range of btScalar.
  constexpr auto least = static_cast<double>(std::numeric_limits<btScalar>::min());
  if (!(area > 1e3 * std::sqrt(least) && area < 1e-3 / std::sqrt(least))) return false;
  // How far Bullet's normal, normalised with few bits, is from this one: docs/guarantee.md.
  const double turn = 1e-4 + 4 * (2 * error * (l1 + l2) + 4 * error * error + 4 * unit_roundoff * l1 * l2) / area;
  if (!(turn <= 0.25)) return false;
  const Eigen::Vector3d normal = product / area;
  for (const Eigen::Vector3d& corner : other) {
    const Eigen::Vector3d from_face = corner - face[0];
    if (!(normal.dot(from_face) > margins + turn * (from_face.norm() + 2 * error) + 8 * error)) return false;
  }
  return true;
}

bool all_in_front(const AttachedMesh& a, const Motion& motion_a, const AttachedMesh& b, const Motion& motion_b,
                  double distance, double error) noexcept {
  if (!a.mesh.faces_match || !b.mesh.faces_match) return false;
  const Eigen::Matrix3d rotation = motion_a.start.linear().transpose() * motion_b.start.linear();
  const Eigen::Vector3d offset =
      motion_a.start.linear().transpose() * (motion_b.start.translation() - motion_a.start.translation());
  const double margins = (a.mesh.margin + b.mesh.margin) * (1 + 8 * unit_roundoff);
  int pairs = 0;
  return for_each_candidate(*a.shape, motion_a, *b.shape, motion_b, distance, [&](TrianglePair pair) {
    if (++pairs > most_pairs) return false;
    const Triangle first = corners(a, pair.a);
    Triangle second = corners(b, pair.b);
    for (Eigen::Vector3d& corner : second) corner = rotation * corner + offset;
    return lies_in_front(first, second, margins, error) || lies_in_front(second, first, margins, error);
  });
}

}  // namespace encage::bullet
