// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/queries/engines.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <cmath>

namespace encage::queries {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Facets = std::vector<Kernel::Triangle_3>;
using Traits = CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Facets::const_iterator>>;

Kernel::Point_3 to_cgal(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

struct CgalTree {
  explicit CgalTree(const TriangleMesh& mesh) {
    for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
      facets.emplace_back(to_cgal(mesh.corner(t, 0)), to_cgal(mesh.corner(t, 1)), to_cgal(mesh.corner(t, 2)));
    }
    tree.insert(facets.begin(), facets.end());
    tree.build();
    tree.accelerate_distance_queries();
  }
  Facets facets;
  CGAL::AABB_tree<Traits> tree;
};

}  // namespace

PointEngine cgal_points(const TriangleMesh& mesh) {
  const auto tree = std::make_shared<CgalTree>(mesh);
  return {"CGAL, AABB tree", [tree](const std::vector<Eigen::Vector3d>& points, std::vector<double>& distances) {
            for (std::size_t i = 0; i < points.size(); ++i) {
              distances[i] = std::sqrt(tree->tree.squared_distance(to_cgal(points[i])));
            }
          }};
}

}  // namespace encage::queries
