// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_body.h"

#include <encage/mass_properties.h>

namespace encage::bullet_bench {
namespace {

/// Relative to the trace. Products of inertia of a mesh that is symmetric are rounding errors, and the principal axes
/// of a ring or a bowl are arbitrary: such meshes keep their own.
constexpr double negligible_product = 1e-6;

}  // namespace

SceneBodyModel::SceneBodyModel(const TriangleMesh& given) : mesh(given), frame(Eigen::Isometry3d::Identity()) {
  const MassProperties mass = mass_properties(given);
  const Eigen::Matrix3d inertia = mass.inertia / mass.mass;
  Eigen::Matrix3d products = inertia;
  products.diagonal().setZero();
  const bool aligned = products.cwiseAbs().maxCoeff() < negligible_product * inertia.trace();
  frame.translation() = mass.centre;
  if (!aligned) frame.linear() = mass.axes;
  moments = aligned ? Eigen::Vector3d(inertia.diagonal()) : Eigen::Vector3d(mass.moments / mass.mass);
  const Eigen::Isometry3d to_body = frame.inverse();
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v)
    mesh.vertices.row(v) = (to_body * given.vertex(v)).transpose();
  // Every method sees the same coordinates.
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  radius = mass.radius;
}

}  // namespace encage::bullet_bench
