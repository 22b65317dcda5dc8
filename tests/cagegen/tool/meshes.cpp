// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/meshes.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

namespace encage::test {

TriangleMesh torus(int around, int along, double tube) {
  TriangleMesh mesh;
  mesh.vertices.resize(std::int64_t{around} * along, 3);
  mesh.triangles.resize(2 * std::int64_t{around} * along, 3);
  const auto index = [&](int i, int j) { return (i % around) * along + j % along; };
  std::int64_t t = 0;
  for (int i = 0; i < around; ++i) {
    const double u = 2 * std::numbers::pi * i / around;
    for (int j = 0; j < along; ++j) {
      const double v = 2 * std::numbers::pi * j / along;
      const double radius = 1 + tube * std::cos(v);
      mesh.vertices.row(index(i, j)) << radius * std::cos(u), radius * std::sin(u), tube * std::sin(v);
      mesh.triangles.row(t++) << index(i, j), index(i + 1, j), index(i + 1, j + 1);
      mesh.triangles.row(t++) << index(i, j), index(i + 1, j + 1), index(i, j + 1);
    }
  }
  return mesh;
}

std::vector<TriangleMesh> coarse_rings() { return {torus(16, 6, 0.45), torus(12, 5, 0.7)}; }

std::string to_obj(const TriangleMesh& mesh) {
  std::ostringstream out;
  out.precision(std::numeric_limits<double>::max_digits10);
  for (const auto& v : mesh.vertices.rowwise()) out << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& t : mesh.triangles.rowwise()) out << "f " << t(0) + 1 << ' ' << t(1) + 1 << ' ' << t(2) + 1 << '\n';
  return out.str();
}

}  // namespace encage::test
