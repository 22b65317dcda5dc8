// SPDX-License-Identifier: GPL-3.0-or-later
// The certificate against a slow, independent route: CGAL's lazy exact kernel on all
// pairs, its Side_of_triangle_mesh and its Polygon_mesh_processing.
#include "cagegen/certify/exact.h"
#include "oracles/meshes.h"

#include <encage/bake.h>

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace encage {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

std::vector<Kernel::Point_3> points(const TriangleMesh& m) {
  std::vector<Kernel::Point_3> result;
  for (Eigen::Index v = 0; v < m.vertices.rows(); ++v) {
    result.emplace_back(m.vertices(v, 0), m.vertices(v, 1), m.vertices(v, 2));
  }
  return result;
}

std::vector<Kernel::Triangle_3> triangles(const TriangleMesh& m) {
  const std::vector<Kernel::Point_3> p = points(m);
  std::vector<Kernel::Triangle_3> result;
  for (Eigen::Index t = 0; t < m.triangles.rows(); ++t) {
    result.emplace_back(p[m.triangles(t, 0)], p[m.triangles(t, 1)], p[m.triangles(t, 2)]);
  }
  return result;
}

/// Nothing if the indices do not make a manifold.
std::optional<Surface> surface(const TriangleMesh& m) {
  std::vector<std::array<std::size_t, 3>> faces;
  for (Eigen::Index t = 0; t < m.triangles.rows(); ++t) {
    faces.push_back({std::size_t(m.triangles(t, 0)), std::size_t(m.triangles(t, 1)), std::size_t(m.triangles(t, 2))});
  }
  if (!PMP::is_polygon_soup_a_polygon_mesh(faces)) return std::nullopt;
  Surface result;
  PMP::polygon_soup_to_polygon_mesh(points(m), faces, result);
  return result;
}

bool any_vertex_on_side(const Surface& closed, const TriangleMesh& of, CGAL::Bounded_side side) {
  const CGAL::Side_of_triangle_mesh<Surface, Kernel> side_of(closed);
  const std::vector<Kernel::Point_3> p = points(of);
  for (Eigen::Index i = 0; i < of.triangles.size(); ++i) {
    if (side_of(p[of.triangles.data()[i]]) == side) return true;
  }
  return false;
}

struct Opinion {
  bool holds = false;
  double distance = 0;
};

/// `inner`: closed, manifold, of positive volume, free of degenerate triangles.
Opinion slow_opinion(const TriangleMesh& inner, const TriangleMesh& cage) {
  const std::optional<Surface> outer = surface(cage);
  if (!outer || !CGAL::is_closed(*outer)) return {};
  const std::vector<Kernel::Triangle_3> outer_triangles = triangles(cage);
  for (const Kernel::Triangle_3& t : outer_triangles) {
    if (t.is_degenerate()) return {};
  }
  if (PMP::does_self_intersect(*outer) || !PMP::does_bound_a_volume(*outer) || !PMP::is_outward_oriented(*outer)) {
    return {};
  }
  Opinion opinion;
  opinion.distance = std::numeric_limits<double>::infinity();
  const std::vector<Kernel::Triangle_3> inner_triangles = triangles(inner);
  for (const Kernel::Triangle_3& a : outer_triangles) {
    const CGAL::Bbox_3 box = a.bbox();
    for (const Kernel::Triangle_3& b : inner_triangles) {
      if (CGAL::do_overlap(box, b.bbox()) && CGAL::do_intersect(a, b)) return {};
    }
  }
  if (any_vertex_on_side(*outer, inner, CGAL::ON_UNBOUNDED_SIDE)) return {};
  if (any_vertex_on_side(*surface(inner), cage, CGAL::ON_BOUNDED_SIDE)) return {};
  opinion.holds = true;
  // Distances in double: CGAL's own, all pairs.
  using Inexact = CGAL::Simple_cartesian<double>;
  const auto inexact = [](const Kernel::Triangle_3& t) {
    const auto p = [&](int k) {
      return Inexact::Point_3(CGAL::to_double(t[k].x()), CGAL::to_double(t[k].y()), CGAL::to_double(t[k].z()));
    };
    return Inexact::Triangle_3(p(0), p(1), p(2));
  };
  std::vector<Inexact::Triangle_3> finer;
  for (const Kernel::Triangle_3& b : inner_triangles) finer.push_back(inexact(b));
  for (const Kernel::Triangle_3& a : outer_triangles) {
    const Inexact::Triangle_3 coarse = inexact(a);
    for (const Inexact::Triangle_3& b : finer) {
      opinion.distance = std::min(opinion.distance, std::sqrt(CGAL::squared_distance(coarse, b)));
    }
  }
  return opinion;
}

/// A sphere or torus with noise; every distance from the core is in [low, high].
TriangleMesh blob(shapes::Random& random, bool ring, double low, double high, int detail) {
  if (!ring) {
    TriangleMesh m = shapes::sphere(detail);
    for (Eigen::Index v = 0; v < m.vertices.rows(); ++v) m.vertices.row(v) *= random(low, high);
    return m;
  }
  TriangleMesh m = shapes::torus(2, 1, detail == 1 ? 8 : 12, detail == 1 ? 4 : 6);
  for (Eigen::Index v = 0; v < m.vertices.rows(); ++v) {
    const Eigen::Vector3d p = m.vertices.row(v);
    const Eigen::Vector3d core = 2 * Eigen::Vector3d(p[0], p[1], 0).normalized();
    m.vertices.row(v) = core + (p - core) * random(low, high);
  }
  return m;
}

/// Damage of many kinds to about half of the cages. `core`: a point inside the inner mesh.
TriangleMesh damaged(shapes::Random& random, TriangleMesh cage, const Eigen::Vector3d& core) {
  const int count = static_cast<int>(cage.triangles.rows());
  const int vertices = static_cast<int>(cage.vertices.rows());
  switch (random.integer(20)) {
    case 0: cage.triangles.row(random.integer(count)).reverseInPlace(); break;
    case 1: cage.triangles.row(random.integer(count)) = cage.triangles.row(count - 1).eval(); break;
    case 2: cage.triangles.conservativeResize(count - 1, 3); break;
    case 3: cage.triangles.col(0).swap(cage.triangles.col(1)); break;
    case 4: cage.vertices.row(random.integer(vertices)) *= random(-1, 0.5); break;
    case 5: cage.vertices.row(random.integer(vertices)) = cage.vertices.row(0).eval(); break;
    case 6: cage = shapes::joined(cage, shapes::cube(random(0.01, 0.3), random.point(2))); break;
    case 7: cage = shapes::joined(cage, shapes::flipped(shapes::cube(random(0.01, 0.3), random.point(2)))); break;
    case 8: cage = shapes::joined(cage, shapes::cube(0.2, {7, 0, 0})); break;
    case 9: cage = shapes::joined(cage, shapes::flipped(shapes::cube(7))); break;
    case 10: cage = shapes::joined(cage, shapes::flipped(shapes::cube(0.05, core))); break;
    default: break;
  }
  return cage;
}

TEST(CertifyOracle, AgreesOnRandomMeshes) {
  int held = 0, refused = 0;
  std::set<std::string> kinds;
  for (std::uint32_t seed = 0; seed < 2500; ++seed) {
    shapes::Random random(seed);
    const bool ring = random.integer(2) == 1;
    const double inner_size = ring ? 0.5 : random(0.5, 1);
    TriangleMesh inner = blob(random, ring, 0.4 * inner_size, inner_size, 1);
    // From deep inside to far outside, often just about touching.
    const double cage_low = random(0.8, ring ? 1.6 : 2.2);
    TriangleMesh cage = blob(random, ring, cage_low * 0.9, cage_low * random(0.9, 1.1), 1 + random.integer(2));
    cage = damaged(random, std::move(cage), ring ? Eigen::Vector3d(2, 0, 0) : Eigen::Vector3d::Zero());
    if (random.integer(8) == 0) inner = shapes::joined(inner, shapes::cube(0.05, random.point(2.5)));
    // Grid coordinates make exact contacts and coplanar triangles frequent.
    if (random.integer(3) == 0) {
      inner.vertices = (inner.vertices * 4).array().round() / 4;
      cage.vertices = (cage.vertices * 4).array().round() / 4;
    }
    const double scale = std::ldexp(1.0, random.integer(40) - 20);
    const Eigen::Vector3d offset = random.integer(2) ? Eigen::Vector3d(random.point(100)) : Eigen::Vector3d::Zero();
    inner = shapes::scaled(shapes::moved(inner, offset), scale);
    cage = shapes::scaled(shapes::moved(cage, offset), scale);

    // The oracle needs an inner mesh that is a manifold solid with proper triangles.
    const std::optional<Surface> solid = surface(inner);
    ASSERT_TRUE(solid) << seed;
    const std::vector<Kernel::Triangle_3> all = triangles(inner);
    if (std::any_of(all.begin(), all.end(), [](const auto& t) { return t.is_degenerate(); })) continue;
    if (PMP::does_self_intersect(*solid) || !PMP::does_bound_a_volume(*solid)) continue;

    const Opinion opinion = slow_opinion(inner, cage);
    const CertifyResult result = certify(inner, Solid::closed, cage);
    ASSERT_EQ(result.holds, opinion.holds) << "seed " << seed << ": " << result.reason;
    if (result.holds) {
      ++held;
      EXPECT_LE(result.certificate.clearance, opinion.distance * (1 + 1e-9)) << seed;
      EXPECT_GE(result.certificate.clearance, opinion.distance * (1 - 2e-6)) << seed;
    } else {
      ++refused;
      std::string kind = result.reason;
      kind.erase(std::remove_if(kind.begin(), kind.end(), [](char c) { return c >= '0' && c <= '9'; }), kind.end());
      kinds.insert(kind);
    }
  }
  // Both answers, for many reasons: the comparison is worth something.
  EXPECT_GT(held, 400);
  EXPECT_GT(refused, 800);
  EXPECT_GE(kinds.size(), 10U);
}

/// Corners on a coarse grid: shared points, collinear and coplanar triangles are frequent.
Eigen::Vector3d grid_point(shapes::Random& random, int planes) {
  const int x = random.integer(4), y = random.integer(4), z = random.integer(planes);
  return Eigen::Vector3d(x, y, z) * 0.1;
}

Kernel::Point_3 exact(const Eigen::Vector3d& p) { return {p[0], p[1], p[2]}; }

Kernel::Triangle_3 exact(const proof::Corners& t) { return {exact(t[0]), exact(t[1]), exact(t[2])}; }

TEST(CertifyOracle, TouchAgreesOnGridTriangles) {
  shapes::Random random(11);
  int answers[2][2] = {};
  for (int i = 0; i < 6000; ++i) {
    const int planes = 1 + random.integer(3);
    const auto triangle = [&] {
      const Eigen::Vector3d a = grid_point(random, planes), b = grid_point(random, planes);
      return proof::Corners{a, b, grid_point(random, planes)};
    };
    const proof::Corners a = triangle(), b = triangle();
    if (exact(a).is_degenerate()) continue;
    const bool flat = exact(b).is_degenerate();
    bool expected = false;
    if (flat) {
      // The union of the three sides is the set itself.
      for (int k = 0; k < 3; ++k) {
        const Kernel::Segment_3 side(exact(b[k]), exact(b[(k + 1) % 3]));
        expected |= side.is_degenerate() ? exact(a).has_on(side.source()) : CGAL::do_intersect(exact(a), side);
      }
    } else {
      expected = CGAL::do_intersect(exact(a), exact(b));
    }
    ASSERT_EQ(proof::touch(a, b), expected) << i;
    ++answers[flat][expected];
  }
  for (const auto& row : answers) {
    EXPECT_GT(row[0], 200);
    EXPECT_GT(row[1], 200);
  }
}

/// Is the intersection of two triangles more than the points that they share by construction?
template <class Allowed>
bool more_than(const proof::Corners& a, const proof::Corners& b) {
  const auto common = CGAL::intersection(exact(a), exact(b));
  return common && boost::get<Allowed>(&*common) == nullptr;
}

TEST(CertifyOracle, OverlapOfNeighboursAgreesOnGridTriangles) {
  shapes::Random random(12);
  int at_vertex[2] = {}, at_edge[2] = {};
  for (int i = 0; i < 6000; ++i) {
    const int planes = 1 + random.integer(3);
    const Eigen::Vector3d v = grid_point(random, planes), a = grid_point(random, planes),
                          b = grid_point(random, planes), c = grid_point(random, planes),
                          d = grid_point(random, planes);
    if (proof::degenerate({v, a, b})) continue;
    if (!proof::degenerate({v, c, d})) {
      const bool expected = more_than<Kernel::Point_3>({v, a, b}, {v, c, d});
      ASSERT_EQ(proof::overlap_at_vertex(v, a, b, c, d), expected) << i;
      ++at_vertex[expected];
    }
    if (!proof::degenerate({v, a, c})) {
      const bool expected = more_than<Kernel::Segment_3>({v, a, b}, {v, a, c});
      ASSERT_EQ(proof::overlap_at_edge(v, a, b, c), expected) << i;
      ++at_edge[expected];
    }
  }
  for (const int* count : {at_vertex, at_edge}) {
    EXPECT_GT(count[0], 500);
    EXPECT_GT(count[1], 500);
  }
}

}  // namespace
}  // namespace encage
