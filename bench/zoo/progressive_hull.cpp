// SPDX-License-Identifier: GPL-3.0-or-later
// In a file of its own: CGAL's headers are slow to compile.
#include "bench/zoo/plain_methods.h"
#include "cagegen/geometry/cgal_mesh.h"
#include "cagegen/geometry/qp3.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <vector>

namespace encage::zoo {

namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Eigen::Vector3d;

// Weight of the distance from the edge's middle against the volume: keeps the linear program bounded.
constexpr double kPull = 1e-3;

/// The least volume that a vertex in place of an edge adds, outside of all planes around it.
struct Outside {
  double lift;  ///< distance from the planes: vertices that have moved touch nothing

  struct Best {
    Vector3d place;
    double volume;
  };

  template <class Profile>
  std::optional<Best> best(const Profile& profile) const {
    const auto point = [&](const auto& v) {
      const Kernel::Point_3& p = get(profile.vertex_point_map(), v);
      return Vector3d(p.x() - profile.p0().x(), p.y() - profile.p0().y(), p.z() - profile.p0().z());
    };
    std::vector<makers::LinearConstraint> planes;
    Vector3d gradient = Vector3d::Zero();  // of the volume under the new triangles
    double before = 0;
    std::size_t index = 0;
    for (const auto& t : profile.triangles()) {
      const Vector3d a = point(t.v0);
      const Vector3d b = point(t.v1);
      const Vector3d c = point(t.v2);
      before += a.dot(b.cross(c)) / 6;
      if (index++ >= 2) gradient += c.cross(a) / 6;  // the first two vanish
      const Vector3d normal = (b - a).cross(c - a);
      if (normal.norm() > 0) planes.push_back({normal.normalized(), normal.normalized().dot(a) + lift});
    }
    const Vector3d end = point(profile.v1());
    const double pull = kPull * (gradient.norm() + end.squaredNorm()) / (end.norm() + lift);
    const auto place = makers::solve_qp(Eigen::Matrix3d::Identity() * pull, pull * end / 2 - gradient, planes);
    if (!place) return std::nullopt;
    const Kernel::Point_3& start = profile.p0();
    return Best{*place + Vector3d(start.x(), start.y(), start.z()), gradient.dot(*place) - before};
  }
};

struct HullPlacement : Outside {
  template <class Profile>
  boost::optional<Kernel::Point_3> operator()(const Profile& profile) const {
    const auto found = best(profile);
    if (!found) return boost::none;
    return Kernel::Point_3(found->place.x(), found->place.y(), found->place.z());
  }
};

struct Cost : Outside {
  template <class Profile>
  boost::optional<double> operator()(const Profile& profile, const boost::optional<Kernel::Point_3>&) const {
    const auto found = best(profile);
    if (!found) return boost::none;
    return found->volume;
  }
};

struct StopAtHullFaces {
  std::size_t faces;
  template <class Value, class Profile>
  bool operator()(const Value&, const Profile& profile, std::size_t, std::size_t) const {
    return profile.surface_mesh().number_of_faces() <= faces;
  }
};

/// Each vertex moved outside of the planes around it: what stays there does not touch the input.
TriangleMesh lifted(const TriangleMesh& mesh, double lift) {
  std::vector<std::vector<makers::LinearConstraint>> planes(static_cast<std::size_t>(mesh.vertices.rows()));
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d normal =
        (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).normalized();
    for (int k = 0; k < 3; ++k) planes[mesh.triangles(t, k)].push_back({normal, lift});
  }
  TriangleMesh result = mesh;
  for (std::size_t v = 0; v < planes.size(); ++v) {
    const auto shift = makers::solve_qp(Eigen::Matrix3d::Identity(), Vector3d::Zero(), planes[v]);
    if (shift) result.vertices.row(static_cast<std::int64_t>(v)) += shift->transpose();
  }
  return result;
}

}  // namespace

TriangleMesh collapse_outward(const TriangleMesh& mesh, std::int64_t faces, double lift) {
  SurfaceMesh surface = makers::to_cgal<Kernel::Point_3>(lifted(mesh, lift));
  sms::edge_collapse(surface, StopAtHullFaces{static_cast<std::size_t>(faces)},
                     CGAL::parameters::get_cost(Cost{{lift}}).get_placement(HullPlacement{{lift}}));
  return makers::from_cgal(surface);
}

}  // namespace encage::zoo
