// SPDX-License-Identifier: Apache-2.0
#include "broadphase/distance/triangle_distance.h"

#include "src/limits.h"
#include "src/mesh/segments.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// The nearest points found so far, and the edges that the line between them should be normal to; an edge is zero if
/// there is none.
struct NearestPoints {
  double squared = infinity;
  Vector on_a, on_b;
  Vector edge_a = Vector::Zero(), edge_b = Vector::Zero();

  void consider(const Vector& p, const Vector& q, const Vector& e, const Vector& f) {
    const double found = (q - p).squaredNorm();
    if (!(found < squared)) return;
    squared = found;
    on_a = p;
    on_b = q;
    edge_a = e;
    edge_b = f;
  }
};

void consider_edges(const TriangleD& a, const TriangleD& b, NearestPoints& nearest) {
  const auto inside = [](double parameter) { return parameter > 0 && parameter < 1; };
  for (int i = 0; i < 3; ++i) {
    const Vector u = a[(i + 1) % 3] - a[i];
    for (int j = 0; j < 3; ++j) {
      const Vector v = b[(j + 1) % 3] - b[j];
      const auto [s, t] = closest_parameters(u, v, a[i] - b[j]);
      const Vector none = Vector::Zero();
      nearest.consider(a[i] + s * u, b[j] + t * v, inside(s) ? u : none, inside(t) ? v : none);
    }
  }
}

/// The plane of a triangle, and points of the triangle.
class Face {
 public:
  explicit Face(const TriangleD& t) : origin_(t[0]), u_(t[1] - t[0]), v_(t[2] - t[0]), normal_(u_.cross(v_)) {
    squared_ = normal_.squaredNorm();
  }

  const Vector& u() const { return u_; }
  const Vector& v() const { return v_; }
  double height(const Vector& p) const { return normal_.dot(p - origin_); }
  /// Computes the foot of `p` on the plane. Returns false if, as computed, it is not in the triangle; otherwise `x` is
  /// a point of the triangle.
  bool foot(const Vector& p, Vector& x) const {
    if (!(squared_ > 0)) return false;
    const Vector w = p - origin_;
    const double s = normal_.dot(w.cross(v_)) / squared_, t = normal_.dot(u_.cross(w)) / squared_;
    if (!(s >= 0 && t >= 0 && s + t <= 1)) return false;
    x = origin_ + s * u_ + t * v_;
    return true;
  }

 private:
  Vector origin_, u_, v_, normal_;
  double squared_;
};

/// Considers corners above the face, and edges through it. With `flip` the points are exchanged.
void consider_face(const Face& face, const TriangleD& other, bool flip, NearestPoints& nearest) {
  const auto consider = [&](const Vector& p, const Vector& e, const Vector& f) {
    Vector x;
    if (!face.foot(p, x)) return;
    flip ? nearest.consider(p, x, e, f) : nearest.consider(x, p, e, f);
  };
  std::array<double, 3> heights;
  for (int k = 0; k < 3; ++k) {
    heights[k] = face.height(other[k]);
    consider(other[k], face.u(), face.v());
  }
  for (int k = 0; k < 3; ++k) {
    const double h = heights[k], next = heights[(k + 1) % 3];
    if ((h > 0) == (next > 0)) continue;
    consider(other[k] + h / (h - next) * (other[(k + 1) % 3] - other[k]), Vector::Zero(), Vector::Zero());
  }
}

/// Distance of the projections on an axis; minus infinity where underflow or overflow could have occurred.
double gap_along(const Vector& n, const TriangleD& a, const TriangleD& b) {
  const double squared = n.squaredNorm();
  if (!(squared > smallest_square && squared < 1 / smallest_square)) return -infinity;
  const double a0 = n.dot(a[0]), a1 = n.dot(a[1]), a2 = n.dot(a[2]);
  const double b0 = n.dot(b[0]), b1 = n.dot(b[1]), b2 = n.dot(b[2]);
  const double gap =
      std::max(std::min({b0, b1, b2}) - std::max({a0, a1, a2}), std::min({a0, a1, a2}) - std::max({b0, b1, b2}));
  return gap / std::sqrt(squared);
}

/// Returns the component of `n` normal to both edges. Between close points the direction is mostly rounding, while the
/// edges are accurate.
Vector normal_to(Vector n, const Vector& e, const Vector& f) {
  const auto without = [](const Vector& x, const Vector& direction) -> Vector {
    const double squared = direction.squaredNorm();
    return squared > 0 ? Vector(x - x.dot(direction) / squared * direction) : x;
  };
  const Vector rest = without(f, e);
  for (int i = 0; i < 2; ++i) n = without(without(n, e), rest);
  return n;
}

double determinant(const Vector& u, const Vector& v, const Vector& w) { return u.dot(v.cross(w)); }

/// True if the edge p q passes through the triangle.
bool passes_through(const Vector& p, const Vector& q, const TriangleD& t, double error) {
  const std::array<Vector, 3> d = {t[0] - p, t[1] - p, t[2] - p};
  const Vector edge = q - p;
  double size = edge.norm();
  for (const Vector& x : d) size = std::max(size, x.norm());
  // A determinant of three differences up to twice the size; each difference is off by twice the error plus rounding.
  const double moved = 2 * error + 8 * eps * size, largest = 2 * size + moved;
  const double bound = 4 * moved * largest * largest + smallest_product;
  const double above = determinant(t[1] - t[0], t[2] - t[0], p - t[0]);
  const double below = determinant(t[1] - t[0], t[2] - t[0], q - t[0]);
  if (!(std::min(std::abs(above), std::abs(below)) > bound) || (above > 0) == (below > 0)) return false;
  const std::array<double, 3> sides = {determinant(edge, d[0], d[1]), determinant(edge, d[1], d[2]),
                                       determinant(edge, d[2], d[0])};
  return std::min({sides[0], sides[1], sides[2]}) > bound || std::max({sides[0], sides[1], sides[2]}) < -bound;
}

}  // namespace

TriangleDistance triangle_distance(const TriangleD& a, const TriangleD& b, double error) noexcept {
  const Face face_a(a), face_b(b);
  NearestPoints nearest;
  nearest.on_a = a[0];
  nearest.on_b = b[0];
  consider_edges(a, b, nearest);
  consider_face(face_a, b, false, nearest);
  consider_face(face_b, a, true, nearest);
  const Vector direction = nearest.on_b - nearest.on_a;
  const double found = direction.norm();

  // Whichever features are nearest, one of the axes is parallel to the line between them.
  double gap = gap_along(direction, a, b);
  const auto consider = [&](const Vector& n) {
    if (found - gap > error) gap = std::max(gap, gap_along(n, a, b));
  };
  consider(normal_to(direction, nearest.edge_a, nearest.edge_b));
  consider(face_a.u().cross(face_a.v()));
  consider(face_b.u().cross(face_b.v()));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) consider((a[(i + 1) % 3] - a[i]).cross(b[(j + 1) % 3] - b[j]));
  }
  return {std::max(0.0, gap - error), found + error, nearest.on_a, nearest.on_b};
}

bool triangles_cross(const TriangleD& a, const TriangleD& b, double error) noexcept {
  for (int k = 0; k < 3; ++k) {
    if (passes_through(a[k], a[(k + 1) % 3], b, error) || passes_through(b[k], b[(k + 1) % 3], a, error)) return true;
  }
  return false;
}

}  // namespace encage
