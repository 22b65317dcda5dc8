// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/near_parts.h"
#include "broadphase/separation/containment.h"

#include <encage/casts.h>
#include <encage/distance.h>
#include <encage/error.h>
#include <encage/fine_lease.h>

#include <algorithm>
#include <optional>

namespace encage {
namespace {

bool is_usable(const ShapeCastOptions& options) {
  const auto length = [](double x) { return x >= 0 && x <= largest_length; };
  return length(options.margin) && length(options.arc) && options.latest >= 0 && options.latest <= 1 &&
         options.most_steps >= 0;
}

bool every_part_has_fine(const Shape& shape, const Motion& motion) {
  return for_each_part(shape, motion, [](const MovingPart& part) { return part.shape->has_fine(); });
}

bool has_unknown_interior(const Shape& shape, const Motion& motion) {
  return !for_each_part(shape, motion, [](const MovingPart& part) {
    FineLease lease;
    const Surface* fine = fine_surface(*part.shape, lease);
    return fine != nullptr && interior(*part.shape) != Interior::unknown;
  });
}

/// True if a vertex of the guest is proven to lie in the host's solid. Asked are the vertices that are farthest along
/// the axes, of each part.
bool holds_vertex(const Shape& host, const Motion& host_at, const Shape& guest, const Motion& guest_at) {
  return !for_each_part(guest, guest_at, [&](const MovingPart& part) {
    FineLease lease;
    const Surface* fine = fine_surface(*part.shape, lease);
    if (fine == nullptr) return true;
    const PosedPart posed(part);
    return std::none_of(fine->parts.begin(), fine->parts.end(), [&](const MeshPart& component) {
      return std::any_of(component.extremes.begin(), component.extremes.end(), [&](std::int32_t v) {
        return contains(host, host_at, posed.world(fine->vertex(v))) == PointSide::inside;
      });
    });
  });
}

ShapeCastResult answered(CastAnswer answer, double time, const std::optional<Contact>& contact) {
  ShapeCastResult result;
  result.answer = answer;
  result.time = time;
  if (contact) {
    result.contact = *contact;
    result.exhausted = contact->exhausted;
  }
  return result;
}

/// Answers for the surfaces alone.
ShapeCastResult from_surfaces(const std::optional<Contact>& contact) {
  if (!contact) return answered(CastAnswer::miss, 1, contact);
  if (contact->overlapping) return answered(CastAnswer::overlapping, 0, contact);
  return answered(contact->exhausted ? CastAnswer::unknown : CastAnswer::hit, contact->time, contact);
}

/// The cast of bodies, with interiors, that are not proven to be apart at the start.
ShapeCastResult from_touch(const Shape& a, const Motion& start_a, const Shape& b, const Motion& start_b,
                           const ShapeCastOptions& options, const std::optional<Contact>& contact) {
  if ((contact && contact->overlapping) || holds_vertex(a, start_a, b, start_b) ||
      holds_vertex(b, start_b, a, start_a)) {
    return answered(CastAnswer::overlapping, 0, contact);
  }
  const DistanceResult start = distance(a, start_a, b, start_b, {.most_steps = options.most_steps});
  if (start.upper == 0 && (start.triangle_a < 0 || start.triangle_b < 0)) {
    return answered(CastAnswer::overlapping, 0, contact);
  }
  // Surfaces that touch, or are within the margin, have a contact at the start.
  if (start.lower > options.margin || (contact && contact->time == 0)) return from_surfaces(contact);
  ShapeCastResult result = answered(CastAnswer::unknown, 0, contact);
  result.exhausted = result.exhausted || start.exhausted;
  return result;
}

ShapeCastResult cast_usable(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                            const ShapeCastOptions& options) {
  PairOptions pair{.margin = options.margin + options.arc, .most_steps = options.most_steps};
  const Verdict verdict = separated(a, motion_a, b, motion_b, pair);
  if (verdict.separated) return answered(CastAnswer::miss, 1, {});
  ShapeCastResult unknown;
  unknown.exhausted = verdict.exhausted;
  if (!every_part_has_fine(a, motion_a) || !every_part_has_fine(b, motion_b)) return unknown;
  const std::optional<Contact> contact = first_contact(
      a, motion_a, b, motion_b,
      {.margin = options.margin, .arc = options.arc, .latest = options.latest, .most_steps = options.most_steps});
  if (!options.solid || (contact && contact->overlapping)) return from_surfaces(contact);
  const Motion start_a = start_of(motion_a), start_b = start_of(motion_b);
  pair.margin = options.margin;
  if (!separated(a, start_a, b, start_b, pair).separated) {
    return from_touch(a, start_a, b, start_b, options, contact);
  }
  // Later a body may get into an unknown interior without touching a surface.
  if (has_unknown_interior(a, start_a) || has_unknown_interior(b, start_b)) return unknown;
  return from_surfaces(contact);
}

}  // namespace

ShapeCastResult cast_shape(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                           const ShapeCastOptions& options) noexcept {
  if (!is_usable(motion_a) || !is_usable(motion_b) || !is_usable(options)) return {};
  try {
    return cast_usable(a, motion_a, b, motion_b, options);
  } catch (const Error&) {  // a mesh of a ShapeCache that cannot be read
    return {};
  }
}

}  // namespace encage
