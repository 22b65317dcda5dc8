// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/body.h"
#include "oracles/exact_pair.h"
#include "oracles/sampled.h"

#include <encage/queries.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {

/// The number of questions that a variable of the environment asks for.
inline int question_count(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : otherwise;
}

/// The least height of a triangle.
inline double width_of(const RealTriangle& t) {
  const Real longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  return longest > 0 ? static_cast<double>((t[1] - t[0]).cross(t[2] - t[0]).norm() / longest) : 0;
}

/// A body in a place, exactly and in long double; its triangles are numbered as those of the fine mesh.
struct PlacedBody {
  ShapePtr shape;
  Motion motion;
  std::string name;
  std::vector<ExactBody> exact;         ///< part by part
  std::vector<bool> solid;              ///< whether the part has an inside
  std::vector<RealTriangle> triangles;  ///< of all parts
  std::vector<Point> centres;           ///< of balls around the triangles
  std::vector<Real> radii;
  double reach = 0;  ///< of the vertices, from the origin of the body's frame
  Eigen::AlignedBox3d box;

  PlacedBody() = default;
  PlacedBody(PlacedBody&&) noexcept = default;

  void add(const Body& body, const Motion& at) {
    exact.emplace_back(body.origin(), body.mesh(), at.start, at.scale);
    solid.push_back(body.solid() && is_closed(body.mesh()));
    for (const RealTriangle& t : at_time(body.mesh(), body.origin(), at, 0)) {
      triangles.push_back(t);
      centres.push_back((t[0] + t[1] + t[2]) / 3);
      Real radius = 0;
      for (const Point& p : t) {
        radius = std::max(radius, (p - centres.back()).norm());
        box.extend(p.cast<double>());
        reach = std::max(reach, static_cast<double>((p - motion.start.translation().cast<Real>()).norm()));
      }
      radii.push_back(radius);
    }
  }

  /// The exact body of a triangle's part, and the triangle's number there.
  std::pair<const ExactBody*, std::int64_t> exact_triangle(std::size_t triangle) const {
    const PartTriangle at = part_triangle(*shape, static_cast<std::int32_t>(triangle));
    return {&exact[static_cast<std::size_t>(at.part)], at.triangle};
  }
  Real distance(const Eigen::Vector3d& point) const {
    Real least = std::numeric_limits<Real>::infinity();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if ((point.cast<Real>() - centres[t]).norm() - radii[t] > least) continue;
      least = std::min(least, point_triangle_distance(point.cast<Real>(), triangles[t]));
    }
    return least;
  }
  /// For a point that is not on the surface: whether the solid of a part has it.
  bool holds(const Eigen::Vector3d& point) const {
    for (std::size_t i = 0; i < exact.size(); ++i) {
      if (solid[i] && winding_number(exact[i], point) != 0) return true;
    }
    return false;
  }
  /// The rounding that <encage/queries.h> promises.
  double rounding(const Eigen::Vector3d& point) const {
    return 1e-13 * (motion.start.translation().norm() + reach + point.norm());
  }
};

inline PlacedBody placed(const Body& body, const Motion& motion) {
  PlacedBody at;
  at.shape = body.shape;
  at.motion = motion;
  at.name = body.sample.name;
  at.add(body, motion);
  return at;
}

/// All samples: concave, hollow, open, flat, thin, with degenerate triangles, in several units.
inline std::vector<Body> query_bodies() {
  std::vector<Body> bodies = sample_bodies();
  for (const auto& more : {flat_shapes(0), thin_shapes(0)}) {
    for (const Sample& s : more) bodies.emplace_back(s);
  }
  Sample degenerate = bodies[1].sample;
  degenerate.name = "box with a segment and a point";
  degenerate.hierarchy.fine = shapes::with_triangle(degenerate.hierarchy.fine, {2, 0, 0}, {2, 0.5, 1}, {2, 0.25, 0.5});
  degenerate.hierarchy.fine = shapes::with_triangle(degenerate.hierarchy.fine, {0, 0, 3}, {0, 0, 3}, {0, 0, 3});
  degenerate.hierarchy.levels.clear();
  bodies.emplace_back(degenerate);
  bodies.emplace_back(scaled(bodies[2].sample, -60));
  bodies.emplace_back(scaled(bodies[5].sample, 70));
  std::erase_if(bodies, [](const Body& body) { return !body.has_fine(); });
  return bodies;
}

/// The bodies in places: as they are, turned, scaled, far away; and compounds of them.
inline std::vector<PlacedBody> placed_bodies(std::uint32_t seed) {
  shapes::Random random(seed);
  std::vector<PlacedBody> all;
  const std::vector<Body> bodies = query_bodies();
  for (const Body& body : bodies) {
    const double size = body.diagonal();
    all.push_back(placed(body, Motion{}));
    all.push_back(placed(body, Motion::resting(random_pose(random, 3 * size))));
    all.push_back(placed(body, Motion::resting(random_pose(random, 1e4 * size), 37.5)));
  }
  for (int i = 0; i < 4; ++i) {
    PlacedBody compound;
    compound.name = "compound " + std::to_string(i);
    compound.motion = Motion::resting(random_pose(random, 2), i < 2 ? 1 : 0.3);
    std::vector<CompoundPart> parts;
    for (int k = 0; k < 5; ++k) {
      const Body& body = bodies[static_cast<std::size_t>(random.integer(8))];
      const CompoundPart part{body.shape, random_pose(random, 2), random(0.3, 1.5)};
      parts.push_back(part);
      // Exact images of parts would be those of rational poses; the rounding of these is far below the promise.
      Motion at;
      at.start.linear() = compound.motion.start.linear() * part.pose.linear();
      at.start.translation() = compound.motion.start * (compound.motion.scale * part.pose.translation());
      at.end = at.start;
      at.scale = compound.motion.scale * part.scale;
      compound.add(body, at);
    }
    compound.shape = make_compound(parts);
    all.push_back(std::move(compound));
  }
  return all;
}

}  // namespace encage::test
