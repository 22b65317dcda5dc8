// SPDX-License-Identifier: Apache-2.0
#include "src/mesh/moments.h"
#include "src/mesh/principal_frame.h"

#include <encage/mass_properties.h>

#include <algorithm>
#include <cmath>

namespace encage {

MassProperties body_of(const Moments& m, const Eigen::Vector3d& apex) {
  if (!(m.volume > 0)) throw Error("mass properties: the mesh encloses no positive volume");
  MassProperties body;
  const Eigen::Vector3d shift = m.first / m.volume;
  const Eigen::Matrix3d covariance = m.second - m.volume * shift * shift.transpose();
  body.mass = m.volume;
  body.centre = apex + shift;
  const double trace = covariance(0, 0) + covariance(1, 1) + covariance(2, 2);
  body.inertia = trace * Eigen::Matrix3d::Identity() - covariance;
  const PrincipalFrame frame = principal_frame(body.inertia);
  body.axes = frame.axes;
  body.moments = frame.values;
  if (!(body.moments[0] > 0)) throw Error("mass properties: the mesh is too thin to have three positive moments");
  return body;
}

MassProperties mass_properties(const TriangleMesh& mesh) {
  if (!is_closed(mesh)) throw Error("mass properties: the mesh is not closed");
  const Eigen::AlignedBox3d box = bounds(mesh);
  const Eigen::Vector3d apex = box.center();
  if (box.isEmpty() || !apex.allFinite()) throw Error("mass properties: the mesh is empty or not finite");
  const auto corner = [&](std::int64_t t, int k) { return mesh.corner(t, k); };
  MassProperties body = body_of(integrate(mesh.triangles.rows(), corner, apex), apex);
  double squared_radius = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      squared_radius = std::max(squared_radius, (mesh.corner(t, k) - body.centre).squaredNorm());
    }
  }
  body.radius = std::sqrt(squared_radius);
  return body;
}

}  // namespace encage
