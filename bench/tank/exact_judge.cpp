// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/exact_judge.h"

#include "oracles/exact_ccd.h"
#include "oracles/exact_pair.h"

#include <algorithm>
#include <array>

namespace encage::tank {
namespace {

const Motion& motion_of(const bench::RecordedStep& step, std::int32_t number) {
  const auto at = std::lower_bound(step.bodies.begin(), step.bodies.end(), number,
                                   [](const bench::RecordedBody& body, std::int32_t n) { return body.body < n; });
  return at->motion;
}

/// How many of Contact::vertices belong to body a.
int corners_of_a(ContactKind kind) {
  switch (kind) {
    case ContactKind::face_vertex: return 3;
    case ContactKind::edge_edge: return 2;
    default: return 1;
  }
}

}  // namespace

Judge exact_judge(const TankBody& body, const ContactOptions& options) {
  return [&body, options](const bench::RecordedStep& step, const BodyContact& reported) -> std::optional<double> {
    const Contact& contact = reported.contact;
    if (contact.overlapping) {
      const auto at_start = [&](std::int32_t number) {
        const Motion& motion = motion_of(step, number);
        return test::ExactBody(body.mesh.origin, body.mesh.mesh, motion.start, motion.scale);
      };
      if (!test::surfaces_meet(at_start(reported.body_a), at_start(reported.body_b), 0)) return std::nullopt;
      return 0.0;
    }
    const Sweep a = make_sweep(body.mesh, motion_of(step, reported.body_a), 0);
    const Sweep b = make_sweep(body.mesh, motion_of(step, reported.body_b), 0);
    // The vertex first.
    constexpr std::array<int, 4> as_they_are = {0, 1, 2, 3}, last_first = {3, 0, 1, 2};
    const std::array<int, 4>& order = contact.kind == ContactKind::face_vertex ? last_first : as_they_are;
    MovingPoints points;
    for (int k = 0; k < 4; ++k) {
      const Sweep& sweep = order[k] < corners_of_a(contact.kind) ? a : b;
      points.start[k] = sweep.start_of(contact.vertices[order[k]]);
      points.end[k] = sweep.end_of(contact.vertices[order[k]]);
    }
    const auto kind = contact.kind == ContactKind::edge_edge ? test::Features::edge_edge : test::Features::vertex_face;
    if (options.margin == 0 && options.arc == 0) {
      if (const auto time = test::exact_first_contact(kind, points)) return time->high;
    }
    // slack without a distance is 2^-40 of the size, each.
    const double distance = options.margin + (a.slack + b.slack) * 0x1p-5;
    std::optional<double> time = test::first_within(kind, points, distance, options.arc, 0x1p-40);
    // The distance is rounded up, so that this time may come before the one asked for.
    if (time) time = std::max(*time, contact.time);
    return time;
  };
}

}  // namespace encage::tank
