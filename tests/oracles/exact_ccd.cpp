// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/exact_ccd.h"

#include <CGAL/Algebraic_kernel_d_1.h>
#include <CGAL/Gmpz.h>
#include <CGAL/Interval_nt.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace encage::test {
namespace {

// Both kinds of features lead to one question: when does a polygon contain the origin, if its corners, differences of
// the features' points, move linearly? The polygon is a triangle or a parallelogram.
using Indices = std::vector<std::array<int, 2>>;  // corner = points[first] - points[second]

const Indices& corners(Features kind) {
  static const Indices face = {{1, 0}, {2, 0}, {3, 0}};
  static const Indices edges = {{0, 2}, {1, 2}, {1, 3}, {0, 3}};
  return kind == Features::vertex_face ? face : edges;
}

// ---- Intervals, which exclude most pairs of features.

using Interval = CGAL::Interval_nt<false>;
using IntervalPoint = std::array<Interval, 3>;
using IntervalPolygon = std::vector<IntervalPoint>;

Interval determinant(const IntervalPoint& a, const IntervalPoint& b, const IntervalPoint& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/// True if some coordinate of all corners has one sign at both ends.
bool one_side(const IntervalPolygon& start, const IntervalPolygon& end) {
  for (int k = 0; k < 3; ++k) {
    bool above = true, below = true;
    for (std::size_t i = 0; i < start.size(); ++i) {
      above = above && start[i][k].inf() > 0 && end[i][k].inf() > 0;
      below = below && start[i][k].sup() < 0 && end[i][k].sup() < 0;
    }
    if (above || below) return true;
  }
  return false;
}

/// True if the origin stays off the plane: the Bernstein coefficients of its determinant have one sign.
bool off_plane(const IntervalPolygon& p, const IntervalPolygon& q) {
  const std::array<Interval, 4> b = {
      determinant(p[0], p[1], p[2]),
      determinant(q[0], p[1], p[2]) + determinant(p[0], q[1], p[2]) + determinant(p[0], p[1], q[2]),
      determinant(q[0], q[1], p[2]) + determinant(q[0], p[1], q[2]) + determinant(p[0], q[1], q[2]),
      determinant(q[0], q[1], q[2])};
  return std::all_of(b.begin(), b.end(), [](const Interval& x) { return x.inf() > 0; }) ||
         std::all_of(b.begin(), b.end(), [](const Interval& x) { return x.sup() < 0; });
}

/// Approximates the point nearest to the origin: rounding only makes the axis of beyond_axis() a worse one.
Eigen::Vector3d nearest_point(const std::vector<Eigen::Vector3d>& p) {
  const Eigen::Vector3d n = (p[1] - p[0]).cross(p[2] - p[1]);
  bool inside = n.squaredNorm() > 0;
  Eigen::Vector3d nearest = p[0];
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Eigen::Vector3d &a = p[i], &b = p[(i + 1) % p.size()], u = b - a;
    const double squared = u.squaredNorm();
    const Eigen::Vector3d q = a + (squared > 0 ? std::clamp(-a.dot(u) / squared, 0.0, 1.0) : 0.0) * u;
    if (q.squaredNorm() < nearest.squaredNorm()) nearest = q;
    inside = inside && n.dot(a.cross(b)) >= 0;
  }
  return inside ? (n.dot(p[0]) / n.squaredNorm() * n).eval() : nearest;
}

/// True if all corners are in front of the origin at both ends, along the direction of the polygon at half-time.
bool beyond_axis(const IntervalPolygon& start, const IntervalPolygon& end) {
  std::vector<Eigen::Vector3d> middle(start.size());
  for (std::size_t i = 0; i < start.size(); ++i) {
    for (int k = 0; k < 3; ++k) middle[i][k] = 0.5 * (start[i][k].inf() + end[i][k].inf());
  }
  const Eigen::Vector3d axis = nearest_point(middle);
  const auto in_front = [&](const IntervalPoint& p) {
    return (p[0] * Interval(axis[0]) + p[1] * Interval(axis[1]) + p[2] * Interval(axis[2])).inf() > 0;
  };
  return axis.allFinite() && std::all_of(start.begin(), start.end(), in_front) &&
         std::all_of(end.begin(), end.end(), in_front);
}

bool surely_free(const IntervalPolygon& start, const IntervalPolygon& end, int depth) {
  if (one_side(start, end) || beyond_axis(start, end) || off_plane(start, end)) return true;
  if (depth == 0) return false;
  IntervalPolygon middle = start;
  for (std::size_t i = 0; i < start.size(); ++i) {
    for (int k = 0; k < 3; ++k) middle[i][k] = (start[i][k] + end[i][k]) * Interval(0.5);
  }
  return surely_free(start, middle, depth - 1) && surely_free(middle, end, depth - 1);
}

bool surely_free(Features kind, const MovingPoints& points) {
  const CGAL::Protect_FPU_rounding<true> upwards;
  IntervalPolygon start, end;
  for (const auto& [i, j] : corners(kind)) {
    IntervalPoint s, e;
    for (int k = 0; k < 3; ++k) {
      s[k] = Interval(points.start[i][k]) - Interval(points.start[j][k]);
      e[k] = Interval(points.end[i][k]) - Interval(points.end[j][k]);
    }
    start.push_back(s);
    end.push_back(e);
  }
  return surely_free(start, end, 14);
}

// ---- Algebraic times.

using Kernel = CGAL::Algebraic_kernel_d_1<CGAL::Gmpz>;
using Polynomial = Kernel::Polynomial_1;
using Time = Kernel::Algebraic_real_1;
using PolynomialPoint = std::array<Polynomial, 3>;

/// Returns `value` as an integer multiple of 2^exponent.
CGAL::Gmpz scaled(double value, int exponent) {
  int e = 0;
  const double mantissa = std::ldexp(std::frexp(value, &e), 53);
  CGAL::Gmpz result(static_cast<long>(mantissa));
  return value == 0 ? result : result << (e - 53 - exponent);
}

int least_exponent(const MovingPoints& points) {
  int least = 1024;
  for (const auto& ends : {points.start, points.end}) {
    for (const Eigen::Vector3d& p : ends) {
      for (int k = 0; k < 3; ++k) {
        int e = 0;
        std::frexp(p[k], &e);
        if (p[k] != 0) least = std::min(least, e - 53);
      }
    }
  }
  return least;
}

PolynomialPoint cross(const PolynomialPoint& a, const PolynomialPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Polynomial dot(const PolynomialPoint& a, const PolynomialPoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Lower bound of p's values on an interval of times >= 0.
Kernel::Bound evaluate_least(const Polynomial& p, const Kernel::Bound& low, const Kernel::Bound& high) {
  Kernel::Bound least(0);
  for (int i = p.degree(); i >= 0; --i) least = least * (least < 0 ? high : low) + p[i];
  return least;
}

/// CGAL's own function (5.5) fails if refinement happens to hit the root.
CGAL::Sign sign(const Polynomial& p, const Time& t) {
  if (p.degree() < 1) return p.is_zero() ? CGAL::ZERO : p.sign_at(0);
  if (t.low() != t.high()) {
    const Polynomial common = CGAL::Polynomial_traits_d<Polynomial>::Gcd_up_to_constant_factor()(p, t.polynomial());
    if (common.degree() > 0 && common.sign_at(t.low()) != common.sign_at(t.high())) return CGAL::ZERO;
  }
  while (t.low() != t.high()) {
    const Kernel::Bound low = std::max(t.low(), Kernel::Bound(0)), high = t.high();
    if (evaluate_least(p, low, high) > 0) return CGAL::POSITIVE;
    if (evaluate_least(-p, low, high) > 0) return CGAL::NEGATIVE;
    t.refine();
  }
  return p.sign_at(t.low());
}

class MovingPolygon {
 public:
  MovingPolygon(Features kind, const MovingPoints& points) {
    const int exponent = least_exponent(points);
    for (const auto& [i, j] : corners(kind)) {
      PolynomialPoint corner;
      for (int k = 0; k < 3; ++k) {
        const CGAL::Gmpz s = scaled(points.start[i][k], exponent) - scaled(points.start[j][k], exponent);
        const CGAL::Gmpz e = scaled(points.end[i][k], exponent) - scaled(points.end[j][k], exponent);
        corner[k] = Polynomial(s, e - s);
      }
      corners_.push_back(corner);
    }
    const std::size_t n = corners_.size();
    normal_ = cross(difference(1, 0), difference(2, 1));
    for (std::size_t i = 0; i < n; ++i) sides_.push_back(dot(normal_, cross(corners_[i], corners_[(i + 1) % n])));
  }

  std::optional<Time> first_contact() const {
    std::vector<Time> times = candidates();
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    for (const Time& t : times) {
      if (holds_origin(t)) return t;
    }
    return std::nullopt;
  }

 private:
  PolynomialPoint difference(int i, int j) const {
    return {corners_[i][0] - corners_[j][0], corners_[i][1] - corners_[j][1], corners_[i][2] - corners_[j][2]};
  }

  /// Returns the times at which a contact can begin.
  std::vector<Time> candidates() const {
    std::vector<Time> times;
    const Polynomial plane = dot(corners_[0], cross(corners_[1], corners_[2]));
    if (!CGAL::is_zero(plane)) {
      add_roots(plane, times);
      return times;
    }
    // The origin stays in the plane: a contact begins where a sign that holds_origin() tests changes.
    times.push_back(kernel_.construct_algebraic_real_1_object()(0));
    for (const Polynomial& p : normal_) add_roots(p, times);
    for (const Polynomial& p : sides_) add_roots(p, times);
    for (const PolynomialPoint& a : corners_) {
      for (const PolynomialPoint& b : corners_) {
        for (const Polynomial& p : cross(a, b)) add_roots(p, times);
        add_roots(dot(a, b), times);
      }
    }
    return times;
  }

  void add_roots(const Polynomial& p, std::vector<Time>& times) const {
    if (p.degree() < 1) return;
    std::vector<std::pair<Time, Kernel::Multiplicity_type>> roots;
    kernel_.solve_1_object()(p, Kernel::Bound(0), Kernel::Bound(1), std::back_inserter(roots));
    for (const auto& root : roots) times.push_back(root.first);
  }

  bool vanishes(const PolynomialPoint& p, const Time& t) const {
    return std::all_of(p.begin(), p.end(), [&](const Polynomial& x) { return sign(x, t) == CGAL::ZERO; });
  }

  /// Valid for times at which the origin is in a plane with the polygon.
  bool holds_origin(const Time& t) const {
    if (!vanishes(normal_, t)) {
      return std::all_of(sides_.begin(), sides_.end(),
                         [&](const Polynomial& side) { return sign(side, t) != CGAL::NEGATIVE; });
    }
    // The corners are collinear: the polygon is the segment between some two of them.
    for (const PolynomialPoint& a : corners_) {
      for (const PolynomialPoint& b : corners_) {
        if (vanishes(cross(a, b), t) && sign(dot(a, b), t) != CGAL::POSITIVE) return true;
      }
    }
    return false;
  }

  Kernel kernel_;
  std::vector<PolynomialPoint> corners_;
  PolynomialPoint normal_;
  std::vector<Polynomial> sides_;  // all >= 0 if the origin is inside
};

// ---- Distances.

using Long = long double;
using LongPoint = Eigen::Matrix<Long, 3, 1>;
using LongPolygon = std::vector<LongPoint>;

Long origin_to_segment(const LongPoint& a, const LongPoint& b) {
  const LongPoint u = b - a;
  const Long uu = u.squaredNorm();
  const Long s = uu > 0 ? std::clamp<Long>(-a.dot(u) / uu, 0, 1) : 0;
  return (a + s * u).norm();
}

Long origin_to_polygon(const LongPolygon& p) {
  const LongPoint n = (p[1] - p[0]).cross(p[2] - p[1]);
  Long least = std::numeric_limits<Long>::infinity();
  bool inside = n.squaredNorm() > 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const LongPoint& next = p[(i + 1) % p.size()];
    least = std::min(least, origin_to_segment(p[i], next));
    inside = inside && n.dot(p[i].cross(next)) >= 0;
  }
  return inside ? std::min(least, std::abs(n.dot(p[0])) / n.norm()) : least;
}

}  // namespace

std::optional<TimeBounds> exact_first_contact(Features kind, const MovingPoints& points) {
  if (surely_free(kind, points)) return std::nullopt;
  const std::optional<Time> time = MovingPolygon(kind, points).first_contact();
  if (!time) return std::nullopt;
  const auto bounds = Kernel().approximate_absolute_1_object()(*time, 60);
  return TimeBounds{CGAL::to_interval(bounds.first).first, CGAL::to_interval(bounds.second).second};
}

std::optional<double> first_within(Features kind, const MovingPoints& points, double distance, double arc,
                                   double resolution) {
  LongPolygon start, motion;
  Long speed = 0;
  for (const auto& [i, j] : corners(kind)) {
    start.push_back(points.start[i].cast<Long>() - points.start[j].cast<Long>());
    motion.push_back(points.end[i].cast<Long>() - points.end[j].cast<Long>() - start.back());
    speed = std::max(speed, motion.back().norm());
  }
  // The distance changes by at most `speed` per unit of time, the requirement by 4 arc.
  const Long change = speed + 4 * static_cast<Long>(arc);
  const auto excess = [&](Long t) {
    LongPolygon p = start;
    for (std::size_t i = 0; i < p.size(); ++i) p[i] += t * motion[i];
    return origin_to_polygon(p) - distance - arc * 4 * t * (1 - t);
  };
  // Advances by the time that the excess at the middle of a span allows; otherwise halves the span.
  Long now = 0, span = 1;
  while (now < 1) {
    span = std::min(span, 1 - now);
    const Long e = excess(now + span / 2);
    if (e > change * span / 2) {
      now += span;
      span *= 2;
    } else if (span <= resolution) {
      return static_cast<double>(now);
    } else {
      span /= 2;
    }
  }
  return std::nullopt;
}

}  // namespace encage::test
