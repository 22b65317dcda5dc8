// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/pair_proof.h"

#include "broadphase/adapters/bullet/box_overlap.h"
#include "broadphase/adapters/bullet/convert.h"
#include "broadphase/shape/shape.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <algorithm>
#include <cmath>

namespace encage::bullet {
namespace {

/// A rotation near a matrix of btScalar, and its distance from that matrix (Frobenius norm).
struct Rotation {
  Eigen::Matrix3d matrix;
  double skew;
};

/// If the matrix is far from a rotation, separated() refuses the result.
Rotation nearest_rotation(const btMatrix3x3& basis) {
  const Eigen::Matrix3d r = to_eigen(basis);
  const Eigen::Matrix3d rotation = nearer_to_rotation(r);
  return {rotation, (rotation - r).norm()};
}

Motion resting(const Rotation& rotation, const Eigen::Vector3d& translation, double scale) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.matrix;
  pose.translation() = translation;
  return Motion::resting(pose, scale);
}

/// Bounds how far Bullet's vertices are from those of the fine mesh: they may be the source's (docs/guarantee.md,
/// "Bullet").
double vertex_error(const AttachedMesh& a) { return a.shape->simple().fine_error * a.mesh.scale; }

constexpr double roundings = 64 * unit_roundoff;  // of the sum of all lengths involved
constexpr double up = 1 + 1e-12;                  // covers the rounding of these computations themselves

}  // namespace

bool proven_apart(const AttachedMesh& a, const btTransform& transform_a, const AttachedMesh& b,
                  const btTransform& transform_b, const PairQuestion& question) noexcept {
  const Rotation rotation_a = nearest_rotation(transform_a.getBasis());
  const Rotation rotation_b = nearest_rotation(transform_b.getBasis());
  const Eigen::Vector3d at_a = to_eigen(transform_a.getOrigin()), at_b = to_eigen(transform_b.getOrigin());
  const Motion motion_a = resting(rotation_a, at_a, a.mesh.scale), motion_b = resting(rotation_b, at_b, b.mesh.scale);
  const double radii = a.mesh.radius + b.mesh.radius;
  const double slack = (rotation_a.skew + rotation_b.skew) * ((at_a - at_b).norm() + radii) +
                       roundings * (at_a.norm() + at_b.norm() + radii) + vertex_error(a) + vertex_error(b);
  const double contact = a.mesh.margin + b.mesh.margin + question.extra;
  const double boxes = std::min(a.mesh.reach + b.mesh.spread, a.mesh.spread + b.mesh.reach) * (1 + 1e-5);
  const double distance = question.false_contacts ? std::max(contact, boxes) : contact;
  if (separated(*a.shape, motion_a, *b.shape, motion_b, (distance + slack) * up).separated) return true;
  if (!question.false_contacts || question.extra > 0) return false;
  return !boxes_may_overlap({a.shape->simple(), a.mesh.scale, a.mesh.growth},
                            {b.shape->simple(), b.mesh.scale, b.mesh.growth}, motion_a.start.inverse() * motion_b.start,
                            slack * up);
}

bool proven_apart(const AttachedMesh& a, const btTransform& transform_a, const btStaticPlaneShape& plane,
                  const btTransform& transform_plane, double extra) noexcept {
  if (a.mesh.loose_vertices) return false;
  const Rotation rotation = nearest_rotation(transform_a.getBasis());
  const Eigen::Vector3d at = to_eigen(transform_a.getOrigin()), plane_at = to_eigen(transform_plane.getOrigin());
  const Eigen::Matrix3d turned = to_eigen(transform_plane.getBasis());
  const Eigen::Vector3d local = to_eigen(plane.getPlaneNormal());
  const double constant = static_cast<double>(plane.getPlaneConstant());
  // The half-space as Bullet sees it: { x : normal . x < height + margins }.
  const Eigen::Vector3d normal = turned * local;
  const double length = normal.norm();
  const double height = normal.dot(turned * (constant * local) + plane_at);
  if (!(std::abs(length - 1) <= 1e-3)) return false;
  const double margin = a.mesh.margin + static_cast<double>(plane.getMargin()) + extra;
  const double slack = rotation.skew * a.mesh.radius +
                       roundings * (at.norm() + a.mesh.radius + plane_at.norm() + std::abs(constant)) + vertex_error(a);
  return separated(*a.shape, resting(rotation, at, a.mesh.scale), HalfSpace{normal / length, height / length},
                   (margin / length + slack) * up)
      .separated;
}

}  // namespace encage::bullet
