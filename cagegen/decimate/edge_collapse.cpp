// SPDX-License-Identifier: GPL-3.0-or-later
// Everything of the decimators that needs CGAL, in one file: its headers are slow to compile.
#include "cagegen/decimate/edge_collapse.h"

#include "cagegen/decimate/embedding_guard.h"
#include "cagegen/geometry/cgal_mesh.h"

#include <encage/error.h>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh_simplification/Edge_collapse_visitor_base.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <vector>

namespace encage::makers {

namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

Eigen::Vector3d to_point(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

/// The triangles around an edge: those that a collapse changes, and those that it removes.
struct Surroundings {
  std::vector<std::int32_t> star;
  std::vector<std::int32_t> lost;

  template <class Profile>
  explicit Surroundings(const Profile& profile) {
    const SurfaceMesh& mesh = profile.surface_mesh();
    for (const auto h : {profile.v0_v1(), profile.v1_v0()}) lost.push_back(static_cast<std::int32_t>(mesh.face(h)));
    for (const auto v : {profile.v0(), profile.v1()}) {
      for (const auto f : CGAL::faces_around_target(mesh.halfedge(v), mesh)) {
        const auto t = static_cast<std::int32_t>(f);
        if (t != lost[0] && t != lost[1]) star.push_back(t);
      }
    }
  }
};

struct StopAtFaces {
  std::size_t faces;
  template <class Cost, class Profile>
  bool operator()(const Cost&, const Profile& profile, std::size_t, std::size_t) const {
    return profile.surface_mesh().number_of_faces() <= faces;
  }
};

struct PlacementFilter {
  EmbeddingGuard* guard;
  template <class Profile>
  boost::optional<Kernel::Point_3> operator()(const Profile& profile, boost::optional<Kernel::Point_3> position) const {
    if (guard == nullptr || !position) return position;
    const Surroundings around(profile);
    const bool allowed = guard->allows(static_cast<std::int32_t>(profile.v0()), static_cast<std::int32_t>(profile.v1()),
                                       around.star, around.lost, to_point(*position));
    return allowed ? position : boost::none;
  }
};

struct Visitor : sms::Edge_collapse_visitor_base<SurfaceMesh> {
  using Base = sms::Edge_collapse_visitor_base<SurfaceMesh>;
  Visitor(EmbeddingGuard* g, const std::function<void()>& c) : guard(g), check(&c) {}

  void count() {
    if (++events % 256 == 0) (*check)();
  }
  void OnCollected(const Base::Profile&, const boost::optional<double>&) { count(); }
  void OnSelected(const Base::Profile&, const boost::optional<double>&, std::size_t, std::size_t) { count(); }
  void OnCollapsing(const Base::Profile& profile, const boost::optional<Kernel::Point_3>& p) {
    if (guard == nullptr) return;
    around.emplace(profile);
    position = to_point(*p);
  }
  void OnCollapsed(const Base::Profile& profile, SurfaceMesh::Vertex_index kept) {
    if (guard == nullptr || !around) return;  // edges without length go first, and unasked
    const auto gone = kept == profile.v0() ? profile.v1() : profile.v0();
    guard->collapsed(static_cast<std::int32_t>(gone), static_cast<std::int32_t>(kept), around->star, around->lost,
                     position);
    around.reset();
  }

  EmbeddingGuard* guard;
  const std::function<void()>* check;
  std::uint64_t events = 0;
  std::optional<Surroundings> around;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

template <class Cost, class Placement>
void collapse(SurfaceMesh& mesh, std::int64_t faces, const Cost& cost, const Placement& placement,
              EmbeddingGuard* guard, const std::function<void()>& check) {
  sms::edge_collapse(mesh, StopAtFaces{static_cast<std::size_t>(faces)},
                     CGAL::parameters::get_cost(cost)
                         .get_placement(placement)
                         .filter(PlacementFilter{guard})
                         .visitor(Visitor(guard, check)));
}

}  // namespace

TriangleMesh collapse_edges(const TriangleMesh& mesh, std::int64_t faces, Decimation kind, std::optional<double> gap,
                            const std::function<void()>& check) {
  // Relative to the middle: the quadrics' error grows with the distance from the origin.
  const Eigen::Vector3d middle = bounds(mesh).center();
  TriangleMesh centred = mesh;
  centred.vertices.rowwise() -= middle.transpose();
  SurfaceMesh surface = to_cgal<Kernel::Point_3>(centred);
  if (static_cast<std::int64_t>(surface.number_of_faces()) != mesh.triangles.rows() || !CGAL::is_closed(surface)) {
    throw Error("decimation: the mesh is not a closed oriented manifold");
  }
  std::optional<EmbeddingGuard> guard;
  if (gap) guard.emplace(centred, *gap);
  EmbeddingGuard* const asked = guard ? &*guard : nullptr;
  if (kind == Decimation::regular) {
    collapse(surface, faces, sms::LindstromTurk_cost<SurfaceMesh>(), sms::LindstromTurk_placement<SurfaceMesh>(), asked,
             check);
  } else {
    const sms::GarlandHeckbert_plane_policies<SurfaceMesh, Kernel> policies(surface);
    collapse(surface, faces, policies.get_cost(), policies.get_placement(), asked, check);
  }
  TriangleMesh result = from_cgal(surface);
  result.vertices.rowwise() += middle.transpose();
  return result;
}

}  // namespace encage::makers
