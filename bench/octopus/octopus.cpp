// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/octopus.h"

#include "bench/octopus/octopus_shape.h"
#include "bench/octopus/polygonize.h"

#include <encage/error.h>

#include <cmath>
#include <string>

namespace encage::octopus {
namespace {

constexpr double octopus_area = 3.9;  // of the shape, about

Eigen::Vector3d centre_of_mass(const TriangleMesh& mesh) {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double volume = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    const double v = a.dot(b.cross(c));
    volume += v;
    moment += v * (a + b + c) / 4;
  }
  return moment / volume;
}

}  // namespace

TriangleMesh make_octopus(std::int64_t faces) {
  if (faces < fewest_octopus_faces || faces > most_octopus_faces) {
    throw Error("octopus: " + std::to_string(faces) + " faces: must be " + std::to_string(fewest_octopus_faces) +
                " to " + std::to_string(most_octopus_faces));
  }
  // The length of an edge, were all triangles equilateral.
  const double detail = std::sqrt(octopus_area * 4 / (std::sqrt(3.0) * static_cast<double>(faces)));
  const ImplicitSurface shape = octopus_shape(detail);
  TriangleMesh mesh = polygonize(shape, {octopus_half_width, 2.98 * detail}, faces, 0.008);
  const Eigen::Vector3d centre = centre_of_mass(mesh);
  mesh.vertices.rowwise() -= centre.transpose();
  const double circumradius = std::sqrt(mesh.vertices.rowwise().squaredNorm().maxCoeff());
  mesh.vertices = (mesh.vertices / circumradius).cast<float>().cast<double>().eval();
  return mesh;
}

}  // namespace encage::octopus
