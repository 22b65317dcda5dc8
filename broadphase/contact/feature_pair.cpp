// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/feature_pair.h"

#include "src/limits.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;
using Lanes = Eigen::Array4d;
using Corners = std::array<Lanes, 3>;  // x, y, z of four points

constexpr int cells = 1 << 22;       // of the grid of times in [0, 1]
constexpr int most_steps = 1 << 10;  // several times the number for hard cases; beyond it a contact is reported
// Bounds the rounding of a projection relative to its projected magnitudes at both ends (differences take 1 unit of
// 2^-53, products and sums 3, interpolation 5), and relative to |axis| (distance + 4 arc) (root and products 8 units,
// sums 6). Axes that turn count twice, because their corners are interpolated first.
constexpr double rounding_unit = 0x1p-49;

/// The difference of the features: a triangle (with its last corner twice) or a parallelogram, whose corners move
/// linearly. The features touch when it contains the origin.
struct DifferenceSweep {
  Corners start, end;
  Corners size;  // sums of the magnitudes at both ends
};

Corners at(const DifferenceSweep& sweep, double time) {
  Corners result;
  for (int k = 0; k < 3; ++k) result[k] = sweep.start[k] + time * (sweep.end[k] - sweep.start[k]);
  return result;
}

Vector corner(const Corners& corners, int i) { return {corners[0][i], corners[1][i], corners[2][i]}; }

Lanes project(const Corners& corners, const Vector& axis) {
  return corners[0] * axis[0] + corners[1] * axis[1] + corners[2] * axis[2];
}

// The order is fixed, so that every instruction set gives the same sum.
double sum(const Lanes& x) { return (x[0] + x[1]) + (x[2] + x[3]); }

int least_lane(const Lanes& x) {
  const int i = x[1] < x[0] ? 1 : 0, j = x[3] < x[2] ? 3 : 2;
  return x[j] < x[i] ? j : i;
}

/// Returns the direction from the origin to the closest point of the polygon, up to rounding. It is as orthogonal as
/// possible to the face or edge that contains that point.
Vector closest_direction(const Corners& p) {
  Corners e;
  for (int k = 0; k < 3; ++k) e[k] = Lanes(p[k][1], p[k][2], p[k][3], p[k][0]) - p[k];
  const Corners moment = {p[1] * e[2] - p[2] * e[1], p[2] * e[0] - p[0] * e[2], p[0] * e[1] - p[1] * e[0]};
  const Vector e0 = corner(e, 0), e1 = corner(e, 1);
  const Vector normal = e0.cross(e1);
  const Lanes side = project(moment, normal);
  if (side.minCoeff() >= 0 && normal.squaredNorm() > 1e-24 * e0.squaredNorm() * e1.squaredNorm()) {
    return normal.dot(corner(p, 0)) > 0 ? normal : Vector(-normal);
  }
  const Lanes length = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
  const Lanes along = -(p[0] * e[0] + p[1] * e[1] + p[2] * e[2]);
  const Lanes s = (along / length.max(std::numeric_limits<double>::min())).max(0.0).min(1.0);
  const Corners c = {p[0] + s * e[0], p[1] + s * e[1], p[2] + s * e[2]};
  const int i = least_lane(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
  if (s[i] <= 0) return corner(p, i);
  if (s[i] >= 1) return corner(p, (i + 1) % 4);
  return corner(e, i).cross(corner(moment, i));
}

/// Searches for a proof for one sweep and one requirement.
class FeatureSearch {
 public:
  FeatureSearch(const DifferenceSweep& sweep, const Requirement& required, double rounding)
      : sweep_(sweep), required_(required), rounding_(rounding) {}

  /// Tries axes from the middle of all corners, each moved towards the corner that violates it most.
  bool quickly_free() const {
    const double least = required_.distance + required_.arc + rounding_;
    Vector axis;
    for (int k = 0; k < 3; ++k) axis[k] = sum(sweep_.start[k] + sweep_.end[k]) / 8;
    for (int attempt = 0; attempt < 3; ++attempt) {
      const double squared = axis.squaredNorm();
      if (!(squared > 1e-200)) return false;
      const Lanes s = project(sweep_.start, axis), e = project(sweep_.end, axis);
      const int i = least_lane(s), j = least_lane(e);
      const double low = std::min(s[i], e[j]);
      const double bound = least * least * squared;
      if (low > 0 && low * low > bound && bound > smallest_square) return true;
      const Vector worst = s[i] < e[j] ? corner(sweep_.start, i) : corner(sweep_.end, j);
      const Vector step = worst - axis;
      axis += std::min(1.0, (squared - low) / step.squaredNorm()) * step;
    }
    return false;
  }

  /// Returns the last cell border up to which the axis proves separation from `now` on; `now` if there is none.
  int free_until(const Vector& axis, int now) const {
    const double squared = axis.squaredNorm();
    if (!(squared > smallest_square)) return now;
    const double length = std::sqrt(squared);
    const Line required = line(time(now));
    const Lanes slack = rounding(length, axis.cwiseAbs());
    const Lanes s = project(sweep_.start, axis), d = project(sweep_.end, axis) - s - length * required.slope;
    const Lanes least = length * required.value + slack;
    if (!(least.minCoeff() > smallest_product && sum(least) < infinity)) return now;
    const auto free_at = [&](int cell) { return (s + time(cell) * d - least).minCoeff() > 0; };
    if (!free_at(now)) return now;
    if (free_at(cells)) return cells;
    double first = 1;
    for (int i = 0; i < 4; ++i) {
      if (d[i] < 0) first = std::min(first, (least[i] - s[i]) / d[i]);
    }
    const int cell = std::clamp(static_cast<int>(first * cells), now, cells);
    if (free_at(cell)) return cell;
    return cell > now && free_at(cell - 1) ? cell - 1 : now;
  }

  /// Advances from proof to proof.
  std::optional<double> run(std::int64_t& spans) const {
    int now = 0;
    double factor = 8;
    for (int step = 0; step < most_steps && !(time(now) > required_.latest); ++step) {
      ++spans;
      int next = advance(now);
      if (next == now) break;
      if (step >= 2 && next < cells) {
        const int end = static_cast<int>(std::min<double>(cells, now + factor * (next - now)));
        const bool free = bent_free(now, end);
        if (free) next = end;
        factor = std::clamp(free ? 2 * factor : factor / 2, 2.0, 1024.0);
      }
      if (next == cells) return std::nullopt;
      now = next;
    }
    if (time(now) > required_.latest) return std::nullopt;
    return time(now);
  }

 private:
  static double time(int cell) { return cell * (1.0 / cells); }

  /// True if an axis that turns during the span, quadratically in time, separates throughout.
  bool bent_free(int now, int end) const {
    const Corners p = at(sweep_, time(now)), q = at(sweep_, time(end));
    const Vector first = closest_direction(p), last = closest_direction(q);
    const Vector middle = 2 * closest_direction(at(sweep_, (time(now) + time(end)) / 2)) - (first + last) / 2;
    const double squared = std::max({first.squaredNorm(), middle.squaredNorm(), last.squaredNorm()});
    if (!(squared > smallest_square)) return false;
    const double length = std::sqrt(squared);
    const Line required = line((time(now) + time(end)) / 2);
    const double r0 = length * (required.value + time(now) * required.slope);
    const double r3 = length * (required.value + time(end) * required.slope);
    const Lanes slack = 2 * rounding(length, first.cwiseAbs().cwiseMax(middle.cwiseAbs()).cwiseMax(last.cwiseAbs()));
    if (!(slack.minCoeff() > smallest_product && sum(slack) < infinity)) return false;
    // Bernstein coefficients of the projections minus the requirement.
    const Lanes b0 = project(p, first) - r0, b3 = project(q, last) - r3;
    const Lanes b1 = (project(q, first) + 2 * project(p, middle) - (2 * r0 + r3)) / 3;
    const Lanes b2 = (project(p, last) + 2 * project(q, middle) - (r0 + 2 * r3)) / 3;
    return (b0.min(b1).min(b2.min(b3)) - slack).minCoeff() > 0;
  }

  struct Line {
    double value, slope;
  };
  /// Returns a line that is nowhere below the requirement and equals it at `touching`; it exists because the arc is
  /// concave in time.
  Line line(double touching) const {
    const double arc = 4 * required_.arc;
    return {required_.distance + arc * touching * touching, arc * (1 - 2 * touching)};
  }

  /// Bounds the rounding of the projections and of the numbers that they are compared with.
  Lanes rounding(double length, const Vector& axis) const {
    return rounding_unit * (project(sweep_.size, axis) + length * (required_.distance + 4 * required_.arc));
  }

  /// Returns the farthest cell border up to which some axis proves separation from `now` on.
  int advance(int now) const {
    const Corners p = at(sweep_, time(now));
    int next = free_until(closest_direction(p), now);
    if (next >= std::min(cells, now + 64)) return next;
    // Tries the polygon and the quads that its edges sweep, in wider and wider spans as long as that helps.
    for (int reach = 1, last = now; reach <= cells - now; reach *= 16, last = next) {
      const Corners q = at(sweep_, time(now + reach));
      if (bent_free(now, now + reach)) next = std::max(next, now + reach);
      const auto consider = [&](const Corners& polygon) {
        next = std::max(next, free_until(closest_direction(polygon), now));
      };
      consider(q);
      for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        Corners quad;
        for (int k = 0; k < 3; ++k) quad[k] = {p[k][i], p[k][j], q[k][j], q[k][i]};
        consider(quad);
      }
      if (next == last) break;
    }
    if (next > now) return next;
    // Coordinate axes contain zeros, which make projections exact.
    for (int k = 0; k < 3; ++k) {
      next = std::max({next, free_until(Vector::Unit(k), now), free_until(-Vector::Unit(k), now)});
    }
    return next;
  }

  const DifferenceSweep& sweep_;
  const Requirement& required_;
  double rounding_ = 0;
};

std::optional<double> first(DifferenceSweep& sweep, const Requirement& required, std::int64_t& spans) {
  for (int k = 0; k < 3; ++k) sweep.size[k] = sweep.start[k].abs() + sweep.end[k].abs();
  const Lanes size = sweep.size[0] + sweep.size[1] + sweep.size[2];
  // Neither NaN nor a value that could overflow to it may get further: a minimum might lose it.
  if (!(sum(size) < 1e100)) return 0.0;
  if (!(required.distance >= 0 && required.arc >= 0)) return 0.0;
  const FeatureSearch search(sweep, required, rounding_unit * size.maxCoeff());
  if (search.quickly_free()) return std::nullopt;
  return search.run(spans);
}

}  // namespace

std::optional<double> first_vertex_face(const MovingPoints& points, const Requirement& required,
                                        std::int64_t& spans) noexcept {
  DifferenceSweep sweep;
  const auto& p = points.start;
  const auto& q = points.end;
  for (int k = 0; k < 3; ++k) {
    sweep.start[k] = Lanes(p[1][k], p[2][k], p[3][k], p[3][k]) - p[0][k];
    sweep.end[k] = Lanes(q[1][k], q[2][k], q[3][k], q[3][k]) - q[0][k];
  }
  return first(sweep, required, spans);
}

std::optional<double> first_edge_edge(const MovingPoints& points, const Requirement& required,
                                      std::int64_t& spans) noexcept {
  DifferenceSweep sweep;
  const auto& p = points.start;
  const auto& q = points.end;
  for (int k = 0; k < 3; ++k) {
    sweep.start[k] = Lanes(p[0][k], p[1][k], p[1][k], p[0][k]) - Lanes(p[2][k], p[2][k], p[3][k], p[3][k]);
    sweep.end[k] = Lanes(q[0][k], q[1][k], q[1][k], q[0][k]) - Lanes(q[2][k], q[2][k], q[3][k], q[3][k]);
  }
  return first(sweep, required, spans);
}

std::optional<double> first_vertex_face(const MovingPoints& points, const Requirement& required) noexcept {
  std::int64_t spans = 0;
  return first_vertex_face(points, required, spans);
}

std::optional<double> first_edge_edge(const MovingPoints& points, const Requirement& required) noexcept {
  std::int64_t spans = 0;
  return first_edge_edge(points, required, spans);
}

std::optional<double> vertex_face_time(const MovingPoints& points, const ContactOptions& options) noexcept {
  return first_vertex_face(points, {options.margin, options.arc, options.latest});
}

std::optional<double> edge_edge_time(const MovingPoints& points, const ContactOptions& options) noexcept {
  return first_edge_edge(points, {options.margin, options.arc, options.latest});
}

}  // namespace encage
