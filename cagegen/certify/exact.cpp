// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/exact.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Interval_nt.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace encage::proof {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point3 = Kernel::Point_3;
using Exact = CGAL::Exact_rational;
using ExactVector = CGAL::Simple_cartesian<Exact>::Vector_3;

Point3 cgal(const Point& p) { return {p[0], p[1], p[2]}; }

Kernel::Triangle_3 cgal(const Corners& t) { return {cgal(t[0]), cgal(t[1]), cgal(t[2])}; }

/// Both points strictly on the same side of the plane of the triangle.
bool same_side(const Point3& a, const Point3& b, const Point3& t0, const Point3& t1, const Point3& t2) {
  const CGAL::Orientation side = CGAL::orientation(t0, t1, t2, a);
  return side != CGAL::COPLANAR && CGAL::orientation(t0, t1, t2, b) == side;
}

bool beside_plane(const Kernel::Triangle_3& plane, const Kernel::Triangle_3& t) {
  return same_side(t[0], t[1], plane[0], plane[1], plane[2]) && same_side(t[0], t[2], plane[0], plane[1], plane[2]);
}

/// The ends of the segment that three collinear points span.
std::pair<Point3, Point3> segment(const Corners& t) {
  const auto less = [](const Point& a, const Point& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  const auto [low, high] = std::minmax_element(t.begin(), t.end(), less);
  return {cgal(*low), cgal(*high)};
}

/// All points in one plane: does the ray from v to x lie in the closed wedge of the rays to a and b?
bool in_wedge(const Point3& v, const Point3& a, const Point3& b, const Point3& x) {
  const int turn = CGAL::coplanar_orientation(v, a, b);
  return turn * CGAL::coplanar_orientation(v, a, x) >= 0 && turn * CGAL::coplanar_orientation(v, x, b) >= 0;
}

int sign(double x) { return (x > 0) - (x < 0); }

/// Orientation of (a, b, p) seen along z, p shifted by (e, e^2); 0 only if a and b coincide in x and y.
int shifted_orientation(const Point& a, const Point& b, const Point& p) {
  const int turn =
      CGAL::orientation(Kernel::Point_2(a[0], a[1]), Kernel::Point_2(b[0], b[1]), Kernel::Point_2(p[0], p[1]));
  if (turn != 0) return turn;
  // Derivatives of the determinant by p.x and p.y: differences of doubles have the exact sign.
  if (a[1] != b[1]) return sign(a[1] - b[1]);
  return sign(b[0] - a[0]);
}

template <class Number>
Number six_volumes(const TriangleMesh& mesh, const std::vector<std::int32_t>& list) {
  Number sum(0);
  const Point& origin = mesh.corner(list[0], 0);
  for (const std::int32_t t : list) {
    Number e[3][3];
    for (int k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 3; ++axis) e[k][axis] = Number(mesh.corner(t, k)[axis]) - Number(origin[axis]);
    }
    sum += e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
  }
  return sum;
}

using ExactCorners = std::array<ExactVector, 3>;

ExactCorners exact(const Corners& t) {
  const auto convert = [](const Point& p) { return ExactVector(Exact(p[0]), Exact(p[1]), Exact(p[2])); };
  return {convert(t[0]), convert(t[1]), convert(t[2])};
}

Exact point_segment(const ExactVector& p, const ExactVector& a, const ExactVector& b) {
  const ExactVector ab = b - a;
  const ExactVector ap = p - a;
  const Exact along = ap * ab;
  const Exact length = ab * ab;
  if (along <= 0) return ap * ap;
  if (along >= length) return (p - b) * (p - b);
  return ap * ap - along * along / length;
}

/// Distance between two lines if both of the nearest points are inside the segments.
void inner_edge_edge(const ExactVector& a, const ExactVector& b, const ExactVector& c, const ExactVector& d,
                     Exact& best) {
  const ExactVector u = b - a;
  const ExactVector v = d - c;
  const ExactVector w = c - a;
  const ExactVector n = CGAL::cross_product(u, v);
  const Exact nn = n * n;
  if (nn == 0) return;
  const Exact s = CGAL::cross_product(w, v) * n;
  const Exact t = CGAL::cross_product(w, u) * n;
  if (s < 0 || s > nn || t < 0 || t > nn) return;
  const Exact height = w * n;
  best = (std::min)(best, Exact(height * height / nn));
}

/// Distance of p from the triangle's plane if the foot is inside the triangle.
void inner_point_face(const ExactVector& p, const ExactCorners& t, Exact& best) {
  const ExactVector n = CGAL::cross_product(t[1] - t[0], t[2] - t[0]);
  const Exact nn = n * n;
  if (nn == 0) return;
  for (int k = 0; k < 3; ++k) {
    if (CGAL::cross_product(t[(k + 1) % 3] - t[k], p - t[k]) * n < 0) return;
  }
  const Exact height = (p - t[0]) * n;
  best = (std::min)(best, Exact(height * height / nn));
}

Exact squared_distance(const ExactCorners& a, const ExactCorners& b) {
  Exact best = (a[0] - b[0]) * (a[0] - b[0]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      best = (std::min)(best, point_segment(a[i], b[j], b[(j + 1) % 3]));
      best = (std::min)(best, point_segment(b[i], a[j], a[(j + 1) % 3]));
      inner_edge_edge(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3], best);
    }
    inner_point_face(a[i], b, best);
    inner_point_face(b[i], a, best);
  }
  return best;
}

}  // namespace

bool degenerate(const Corners& triangle) {
  return CGAL::collinear(cgal(triangle[0]), cgal(triangle[1]), cgal(triangle[2]));
}

bool touch(const Corners& a, const Corners& b) {
  const Kernel::Triangle_3 ta = cgal(a);
  const Kernel::Triangle_3 tb = cgal(b);
  // Orientations have fast filters; the whole test falls back to rationals more often.
  if (beside_plane(ta, tb)) return false;
  if (degenerate(b)) {
    const auto [from, to] = segment(b);
    return from == to ? ta.has_on(from) : CGAL::do_intersect(ta, Kernel::Segment_3(from, to));
  }
  return !beside_plane(tb, ta) && CGAL::do_intersect(ta, tb);
}

bool overlap_at_vertex(const Point& v, const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point3 pv = cgal(v), pa = cgal(a), pb = cgal(b), pc = cgal(c), pd = cgal(d);
  if (same_side(pa, pb, pv, pc, pd) || same_side(pc, pd, pv, pa, pb)) return false;
  if (CGAL::coplanar(pv, pa, pb, pc) && CGAL::coplanar(pv, pa, pb, pd)) {
    return in_wedge(pv, pa, pb, pc) || in_wedge(pv, pa, pb, pd) || in_wedge(pv, pc, pd, pa) || in_wedge(pv, pc, pd, pb);
  }
  // The intersection is convex and holds v: anything more leaves one of the triangles through the edge facing v.
  return CGAL::do_intersect(Kernel::Triangle_3(pv, pa, pb), Kernel::Segment_3(pc, pd)) ||
         CGAL::do_intersect(Kernel::Triangle_3(pv, pc, pd), Kernel::Segment_3(pa, pb));
}

bool overlap_at_edge(const Point& v, const Point& w, const Point& a, const Point& b) {
  const Point3 pv = cgal(v), pw = cgal(w), pa = cgal(a), pb = cgal(b);
  return CGAL::coplanar(pv, pw, pa, pb) &&
         CGAL::coplanar_orientation(pv, pw, pa) == CGAL::coplanar_orientation(pv, pw, pb);
}

int crossing_above(const Corners& triangle, const Point& p) {
  const int turn = shifted_orientation(triangle[0], triangle[1], p);
  if (turn == 0 || shifted_orientation(triangle[1], triangle[2], p) != turn ||
      shifted_orientation(triangle[2], triangle[0], p) != turn) {
    return 0;
  }
  // POSITIVE: p is on the side that sees the triangle counter-clockwise, which is above it if turn > 0.
  const int side = CGAL::orientation(cgal(triangle[0]), cgal(triangle[1]), cgal(triangle[2]), cgal(p));
  return side * turn < 0 ? turn : 0;
}

int volume_sign(const TriangleMesh& mesh, const std::vector<std::int32_t>& list) {
  {
    CGAL::Protect_FPU_rounding<true> upwards;
    const CGAL::Interval_nt<false> volume = six_volumes<CGAL::Interval_nt<false>>(mesh, list);
    if (volume.inf() > 0) return 1;
    if (volume.sup() < 0) return -1;
  }
  return CGAL::sign(six_volumes<Exact>(mesh, list));
}

double exact_distance(const Corners& a, const Corners& b) {
  const double squared = CGAL::to_interval(squared_distance(exact(a), exact(b))).first;
  // Below, squaring has left the range where relative bounds hold.
  if (!(squared > 0x1p-1000)) return 0;
  return std::sqrt(squared) * (1 - 0x1p-50);
}

}  // namespace encage::proof
