// SPDX-License-Identifier: GPL-3.0-or-later
// First contact of a vertex and a face, and of two edges.
#include "oracles/exact_ccd.h"
#include "oracles/twins/pair_kind.h"

#include <encage/contact.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

namespace encage::twins {

using test::Features;
using test::TwinRandom;
using Vector = Eigen::Vector3d;

namespace {

template <class Function>
void change(MovingPoints& points, const Function& function) {
  for (auto* ends : {&points.start, &points.end}) {
    for (Vector& p : *ends) p = function(p);
  }
}

MovingPoints any_points(TwinRandom& random) {
  MovingPoints points;
  // Small integers meet in every degenerate way; large ones are rounded.
  const double size = std::array{0.0, 1.0, 2.0, 3.0, 0x1p26}[random.below(5)];
  change(points, [&](const Vector&) -> Vector {
    return size == 0 ? random.point(1) : random.point(size + 0.5).array().round().matrix().eval();
  });
  return points;
}

/// Makes the motion a member of a family in which contacts are degenerate.
void specialise(TwinRandom& random, Features kind, MovingPoints& p) {
  const unsigned first = kind == Features::vertex_face ? 1 : 2;
  const auto integer = [&] { return static_cast<double>(random.below(5)) - 2; };
  switch (random.below(10)) {
    case 0: {  // translations
      const Vector u = p.end[0] - p.start[0], v = p.end[3] - p.start[3];
      for (unsigned i = 0; i < 4; ++i) p.end[i] = p.start[i] + (i < first ? u : v);
      break;
    }
    case 1: {  // in a plane throughout
      Eigen::Matrix3d m;
      for (int k = 0; k < 9; ++k) m(k) = integer();
      change(p, [&](const Vector& x) { return Vector(m * Vector(x.x(), x.y(), 0)); });
      break;
    }
    case 2: {  // on a line throughout
      const Vector direction(integer(), integer(), integer());
      change(p, [&](const Vector& x) { return Vector(direction * x.x() + Vector(1, 2, 3)); });
      break;
    }
    case 3: {  // points that coincide
      const unsigned i = random.below(4), j = random.below(4);
      p.start[i] = p.start[j];
      if (random.coin()) p.end[i] = p.end[j];
      break;
    }
    case 4:  // parallel edges, or an edge of the face parallel to the other edge
      p.start[3] = p.start[2] + p.start[1] - p.start[0];
      if (random.coin()) p.end[3] = p.end[2] + (p.end[1] - p.end[0]) * integer();
      break;
    case 5: {  // contact at an end of the step
      auto& ends = random.coin() ? p.start : p.end;
      if (kind == Features::vertex_face) {
        ends[0] = random.coin() ? ends[1] : Vector((ends[1] + ends[2] + 2 * ends[3]) / 4);
      } else {
        ends[3] = random.coin() ? ends[0] : Vector((3 * ends[0] + ends[1]) / 2 - ends[2]);
      }
      break;
    }
    case 6: {  // on both sides of a plane, almost touching
      const double gap = std::pow(10.0, -random.uniform(3, 17));
      for (auto* ends : {&p.start, &p.end}) {
        for (unsigned i = 0; i < 4; ++i) {
          const double z = random.below(3) == 0 ? 0 : std::abs((*ends)[i].z());
          (*ends)[i].z() = i < first ? z + gap : -z;
        }
      }
      if (random.coin()) {
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()).toRotationMatrix();
        change(p, [&](const Vector& x) { return Vector(turn * x); });
      }
      break;
    }
    default: break;
  }
}

/// Moves the points far from the origin, makes them tiny or huge, or changes them by a few units in the last place.
double set(TwinRandom& random, MovingPoints& p) {
  double scale = 1;
  switch (random.below(8)) {
    case 0: {
      const Vector offset = random.point(3).array().round() * (random.coin() ? 1e6 : 1e9);
      change(p, [&](const Vector& x) { return Vector(x / 8 + offset); });
      return 1.0 / 8;
    }
    case 1: scale = std::array{0x1p-130, 0x1p-60, 0x1p60, 0x1p100}[random.below(4)]; break;
    case 2: change(p, [&](const Vector& x) { return Vector(x + random.point(0x1p-50)); }); break;
    default: break;
  }
  change(p, [&](const Vector& x) { return Vector(x * scale); });
  return scale;
}

double speed(const MovingPoints& p) {
  double most = 0;
  for (int i = 0; i < 4; ++i) most = std::max(most, (p.end[i] - p.start[i]).norm());
  return 2 * most;
}

class FeaturePairs : public PairKind {
 public:
  explicit FeaturePairs(Features kind) : kind_(kind) {}

  Outcome ask(TwinRandom& random, std::int64_t) const override {
    MovingPoints points = any_points(random);
    specialise(random, kind_, points);
    const double scale = set(random, points);
    return random.below(8) == 0 ? with_margin(random, points, scale) : exactly(points, scale);
  }

 private:
  std::optional<double> time(const MovingPoints& points, const ContactOptions& options) const {
    return kind_ == Features::vertex_face ? vertex_face_time(points, options) : edge_edge_time(points, options);
  }

  Outcome exactly(const MovingPoints& points, double scale) const {
    const std::optional<double> said = time(points, {});
    const std::optional<test::TimeBounds> exact = exact_first_contact(kind_, points);
    Outcome outcome{.rejected = !said, .sampled = true, .truth = exact ? Truth::touching : Truth::apart};
    outcome.missed = exact && !(said && *said <= exact->high);
    if (outcome.missed) outcome.what = text(points, {});
    outcome.far = !exact && !first_within(kind_, points, 0.01 * scale, 0, 0x1p-10);
    return outcome;
  }

  /// first_within() reports a time only if the features are within this distance soon after it.
  Outcome with_margin(TwinRandom& random, const MovingPoints& points, double scale) const {
    constexpr double fine = 0x1p-16;
    const ContactOptions options{.margin = random.uniform(0.01, 0.5) * scale,
                                 .arc = random.coin() ? 0 : random.uniform(0, 0.3) * scale};
    const std::optional<double> said = time(points, options);
    const double certain = options.margin - fine * (speed(points) + 4 * options.arc);
    const auto surely = certain > 0 ? first_within(kind_, points, certain, options.arc, fine) : std::nullopt;
    Outcome outcome{.rejected = !said, .sampled = true, .truth = surely ? Truth::within_margin : Truth::apart};
    outcome.missed = surely && !(said && *said <= *surely + fine);
    if (outcome.missed) outcome.what = text(points, options);
    outcome.far = !first_within(kind_, points, options.margin + 0.05 * scale, options.arc, 0x1p-10);
    return outcome;
  }

  static std::string text(const MovingPoints& points, const ContactOptions& options) {
    std::ostringstream out;
    out << std::hexfloat << "margin " << options.margin << ", arc " << options.arc;
    for (const auto& ends : {points.start, points.end}) {
      for (const Vector& p : ends) out << " (" << p.x() << ", " << p.y() << ", " << p.z() << ")";
    }
    return out.str();
  }

  Features kind_;
};

}  // namespace

std::unique_ptr<PairKind> vertex_faces() { return std::make_unique<FeaturePairs>(Features::vertex_face); }
std::unique_ptr<PairKind> edge_edges() { return std::make_unique<FeaturePairs>(Features::edge_edge); }

}  // namespace encage::twins
