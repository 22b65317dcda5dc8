// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/feature_pair.h"
#include "broadphase/distance/triangle_distance.h"
#include "broadphase/separation/surface_pair.h"
#include "broadphase/shape/compound.h"
#include "src/limits.h"
#include "src/mesh/segments.h"

#include <encage/contact.h>
#include <encage/error.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

Vector at(const MovingPoints& points, std::size_t i, double t) { return (1 - t) * points.start[i] + t * points.end[i]; }

void require_usable(const Motion& motion, const char* body) {
  if (!is_usable(motion)) throw Error(std::string("first contact: ") + body + ": " + motion_defect(motion));
}

/// Barycentric coordinates of the point of the triangle closest to p, up to rounding.
Vector weights_in_triangle(const Vector& p, const std::array<Vector, 3>& corner) {
  const Vector n = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  Vector w;
  for (int k = 0; k < 3; ++k) {
    const Vector &a = corner[(k + 1) % 3], &b = corner[(k + 2) % 3];
    w[k] = (b - a).cross(p - a).dot(n);
  }
  if (w.minCoeff() >= 0 && w.sum() > 0) return w / w.sum();
  // p is beside the triangle, or the triangle is degenerate: the closest point lies on an edge.
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int k1 = (k + 1) % 3;
    const Vector along = corner[k1] - corner[k];
    const double length = along.squaredNorm();
    const double t = length > 0 ? std::clamp(along.dot(p - corner[k]) / length, 0.0, 1.0) : 0;
    const double distance = (corner[k] + t * along - p).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    w.setZero();
    w[k] = 1 - t;
    w[k1] = t;
  }
  return w;
}

}  // namespace

// Not anonymous: types of PairContact are made of these.
namespace contact {

/// Position and direction of the contact of two features, in the common frame.
struct Meeting {
  Eigen::Vector3d on_a, on_b;  ///< at the time of contact
  Eigen::Vector3d path;        ///< of a's point relative to b's during the step
  Eigen::Vector3d normal;      ///< of the features, any length and sign
};

/// Corners of two triangles at the time of contact, in the common frame.
struct CornerPair {
  TriangleD a, b;
};

}  // namespace contact

namespace {

using contact::CornerPair;
using contact::Meeting;

/// Meeting of the vertex points[0] and the face of the other three points. `vertex_is_a` is true if the vertex belongs
/// to a.
Meeting meet_vertex_face(const MovingPoints& points, double t, bool vertex_is_a) {
  const Vector p = at(points, 0, t), a = at(points, 1, t), b = at(points, 2, t), c = at(points, 3, t);
  const Vector w = weights_in_triangle(p, {a, b, c});
  const auto moved = [&](std::size_t i) -> Vector { return points.end[i] - points.start[i]; };
  const Vector on_face = w[0] * a + w[1] * b + w[2] * c;
  const Vector path = moved(0) - (w[0] * moved(1) + w[1] * moved(2) + w[2] * moved(3));
  const Vector normal = (b - a).cross(c - a);
  return vertex_is_a ? Meeting{p, on_face, path, normal} : Meeting{on_face, p, -path, normal};
}

/// Meeting of the edge points[0] points[1] of a and the edge points[2] points[3] of b.
Meeting meet_edges(const MovingPoints& points, double t) {
  const Vector p0 = at(points, 0, t), p1 = at(points, 1, t), q0 = at(points, 2, t), q1 = at(points, 3, t);
  const auto [s, r] = closest_parameters(p1 - p0, q1 - q0, p0 - q0);
  const auto moved = [&](std::size_t i) -> Vector { return points.end[i] - points.start[i]; };
  return {p0 + s * (p1 - p0), q0 + r * (q1 - q0),
          (1 - s) * moved(0) + s * moved(1) - ((1 - r) * moved(2) + r * moved(3)), (p1 - p0).cross(q1 - q0)};
}

Meeting meet(ContactKind kind, const MovingPoints& points, double t) {
  return kind == ContactKind::edge_edge ? meet_edges(points, t)
                                        : meet_vertex_face(points, t, kind == ContactKind::vertex_face);
}

TriangleD at(const MovingTriangle& triangle, double t) {
  return {triangle.corner(0, t), triangle.corner(1, t), triangle.corner(2, t)};
}

/// The farthest that a triangle reaches along a direction from a point.
double reach(const TriangleD& triangle, const Vector& from, const Vector& direction) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Vector& corner : triangle) most = std::max(most, direction.dot(corner - from));
  return most;
}

double longest_edge(const TriangleD& t) {
  return std::sqrt(std::max({(t[1] - t[0]).squaredNorm(), (t[2] - t[1]).squaredNorm(), (t[0] - t[2]).squaredNorm()}));
}

/// How far the triangles reach to the other's side of the plane of contact.
double overlap_along(const Vector& normal, const Meeting& meeting, const CornerPair& corners) {
  return std::max(reach(corners.a, meeting.on_a, -normal), reach(corners.b, meeting.on_b, normal));
}

/// How far b's triangle faces along the normal and a's against it, from -2 to 2: outward normals, if bodies are closed.
double facing(const Vector& normal, const CornerPair& corners) {
  return normal.dot(unit_normal(corners.b) - unit_normal(corners.a));
}

/// Unit normal from b towards a, of features that are no farther apart than rounding.
Vector normal_in_contact(const Meeting& meeting, const CornerPair& corners, double slack) {
  const Vector apart = meeting.on_a - meeting.on_b;
  Vector n = meeting.normal;
  if (!(n.squaredNorm() > smallest_square)) n = meeting.path;
  if (!(n.squaredNorm() > smallest_square)) n = apart;
  if (!(n.squaredNorm() > smallest_square)) return Vector::UnitZ();
  n.normalize();
  // a comes from the side that it moves away from. Where it moves along the features, or rests, the triangles are on
  // their own sides.
  const double along = n.dot(meeting.path);
  if (std::abs(along) > 1e-9 * meeting.path.norm()) return along > 0 ? Vector(-n) : n;
  const double overlap = overlap_along(n, meeting, corners), other_way = overlap_along(-n, meeting, corners);
  if (std::abs(overlap - other_way) > slack) return overlap > other_way ? Vector(-n) : n;
  return facing(n, corners) < 0 ? Vector(-n) : n;
}

/// True if the first triangle lies on one side of the other one's plane, roundings left out.
bool beside(const TriangleD& a, const TriangleD& b) {
  const Vector normal = (b[1] - b[0]).cross(b[2] - b[0]);
  const double x = normal.dot(a[0] - b[0]), y = normal.dot(a[1] - b[0]), z = normal.dot(a[2] - b[0]);
  return (x > 0 && y > 0 && z > 0) || (x < 0 && y < 0 && z < 0);
}

std::array<std::int32_t, 4> sorted(std::int32_t x, std::array<std::int32_t, 3> rest) {
  std::sort(rest.begin(), rest.end());
  return {x, rest[0], rest[1], rest[2]};
}

}  // namespace

/// During the step, in the common frame.
struct PairContact::Triangles {
  const MovingTriangle& a;
  const MovingTriangle& b;
};

/// A triangle during the step, in the common frame, the numbers of its vertices, and the features that it owns as in
/// MeshArrays::owned.
struct PairContact::Placed {
  MovingTriangle triangle;
  std::array<std::int32_t, 3> vertices;
  unsigned owned;
};

struct PairContact::Found {
  double time;
  ContactKind kind;
  std::array<std::int32_t, 4> vertices;
  Meeting meeting;
  CornerPair corners;
};

bool PairContact::Side::turn_to(std::int32_t triangle) {
  if (part != nullptr && triangle >= first_triangle && triangle - first_triangle < triangle_count) return false;
  MovingPart moving;
  if (body.is_compound()) {
    const CompoundShape& compound = body.compound();
    moving = moving_part(compound, part_of_triangle(compound, triangle), body_motion);
  } else {
    moving = {&body.simple(), body_motion};
  }
  lease = FineLease(*moving.shape);
  part = moving.shape;
  motion = moving.motion;
  slack = moving.slack;
  first_triangle = moving.first_triangle;
  first_vertex = moving.first_vertex;
  triangle_count = static_cast<std::int32_t>(part->fine.mesh.triangles.size());
  assert(!part->fine.empty());
  return true;
}

PairContact::PairContact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                         const ContactOptions& options)
    : a_(a, motion_a), b_(b, motion_b), options_(options), latest_(options.latest) {
  require_usable(motion_a, "body a");
  require_usable(motion_b, "body b");
  if (!a.is_compound()) a_.turn_to(0);
  if (!b.is_compound()) b_.turn_to(0);
}

void PairContact::turn_to(std::int32_t triangle_a, std::int32_t triangle_b) {
  const bool turned_a = a_.turn_to(triangle_a), turned_b = b_.turn_to(triangle_b);
  if (!turned_a && !turned_b && placed_) return;
  placed_ = true;
  const LocalFrame &local_a = a_.part->frame, &local_b = b_.part->frame;
  const PairMotion pair = pair_motion(local_a, a_.motion, local_b, b_.motion);
  a_.ends = pair.a;
  b_.ends = pair.b;
  const double margin = options_.margin + a_.slack + b_.slack + a_.part->contact_margin(a_.motion.scale) +
                        b_.part->contact_margin(b_.motion.scale);
  required_ = required_distance(local_a, a_.motion, local_b, b_.motion, margin);
  rounding_ = required_distance(local_a, a_.motion, local_b, b_.motion, 0);
}

PairContact::Placed PairContact::placed(const Side& side, std::int32_t triangle) {
  triangle -= side.first_triangle;
  const auto& t = side.part->fine.mesh.triangles[triangle];
  const LeafTriangle leaf = {
      {static_cast<std::int32_t>(t[0]), static_cast<std::int32_t>(t[1]), static_cast<std::int32_t>(t[2])}, triangle};
  std::array<std::int32_t, 3> numbers = leaf.vertices;
  for (std::int32_t& v : numbers) v += side.first_vertex;
  return {moving_triangle({side.part->fine, side.motion.scale}, side.ends, leaf), numbers,
          side.part->fine.owned[triangle]};
}

template <class Visit>
void PairContact::for_each_feature_pair(const Placed& a, const Placed& b, Visit&& visit) {
  const auto& [ta, va, owned_a] = a;
  const auto& [tb, vb, owned_b] = b;
  for (unsigned i = 0; i < 3; ++i) {
    if ((owned_a >> i & 1U) != 0) {
      visit(ContactKind::vertex_face,
            MovingPoints{{ta.start[i], tb.start[0], tb.start[1], tb.start[2]},
                         {ta.end[i], tb.end[0], tb.end[1], tb.end[2]}},
            sorted(va[i], vb));
    }
    if ((owned_b >> i & 1U) != 0) {
      auto ids = sorted(vb[i], va);
      std::rotate(ids.begin(), ids.begin() + 1, ids.end());
      visit(ContactKind::face_vertex,
            MovingPoints{{tb.start[i], ta.start[0], ta.start[1], ta.start[2]},
                         {tb.end[i], ta.end[0], ta.end[1], ta.end[2]}},
            ids);
    }
  }
  for (unsigned i = 0; i < 3; ++i) {
    if ((owned_a >> (3 + i) & 1U) == 0) continue;
    const unsigned i1 = (i + 1) % 3;
    for (unsigned j = 0; j < 3; ++j) {
      if ((owned_b >> (3 + j) & 1U) == 0) continue;
      const unsigned j1 = (j + 1) % 3;
      visit(ContactKind::edge_edge,
            MovingPoints{{ta.start[i], ta.start[i1], tb.start[j], tb.start[j1]},
                         {ta.end[i], ta.end[i1], tb.end[j], tb.end[j1]}},
            std::array<std::int32_t, 4>{std::min(va[i], va[i1]), std::max(va[i], va[i1]), std::min(vb[j], vb[j1]),
                                        std::max(vb[j], vb[j1])});
    }
  }
}

void PairContact::test(std::int32_t triangle_a, std::int32_t triangle_b) {
  turn_to(triangle_a, triangle_b);
  steps_ += 16;
  const Placed a = placed(a_, triangle_a), b = placed(b_, triangle_b);
  const Triangles triangles{a.triangle, b.triangle};
  for_each_feature_pair(a, b,
                        [&](ContactKind kind, const MovingPoints& points, const std::array<std::int32_t, 4>& vertices) {
                          consider(kind, points, vertices, triangles);
                        });
  note_crossing(triangles, a.vertices, b.vertices);
}

void PairContact::consider(ContactKind kind, const MovingPoints& points, const std::array<std::int32_t, 4>& vertices,
                           const Triangles& triangles) noexcept {
  ++feature_tests_;
  const Requirement required = {required_, options_.arc, latest_};
  std::int64_t spans = 0;
  const auto time = kind == ContactKind::edge_edge ? first_edge_edge(points, required, spans)
                                                   : first_vertex_face(points, required, spans);
  steps_ += 1 + 16 * spans;
  if (!time) return;
  const Meeting meeting = meet(kind, points, *time);
  add({*time, kind, vertices, meeting, {at(triangles.a, *time), at(triangles.b, *time)}});
}

void PairContact::add(const Found& found) noexcept {
  const auto& [time, kind, vertices, meeting, corners] = found;
  ++contacts_;
  steps_ += 8;
  const Vector apart = meeting.on_a - meeting.on_b;
  const double scale_a = a_.motion.scale, scale_b = b_.motion.scale;
  const double margin = options_.margin + a_.part->contact_margin(scale_a) + b_.part->contact_margin(scale_b);
  if (time == 0) {
    const double radii = a_.part->least_radius(scale_a) + b_.part->least_radius(scale_b);
    const double errors = a_.part->core_error_in_world(scale_a) + b_.part->core_error_in_world(scale_b);
    overlapping_ |= apart.norm() + errors + rounding_ + a_.slack + b_.slack < radii;
  }
  // Across a margin the closest points define the direction; in contact their difference is mere rounding.
  const double distance = margin > 0 ? std::max(apart.norm(), 16 * rounding_) : 0;
  const double slack = 1e-6 * (longest_edge(corners.a) + longest_edge(corners.b)) + 16 * rounding_;
  const Vector normal = distance > 16 * rounding_ ? apart.normalized() : normal_in_contact(meeting, corners, slack);
  Ranked ranked;
  ranked.rank.distance = distance;
  ranked.rank.unsupported = overlap_along(normal, meeting, corners) > slack;
  ranked.rank.receding = normal.dot(meeting.path) / std::max(meeting.path.norm(), std::sqrt(smallest_square));
  ranked.rank.averted = -facing(normal, corners);
  ranked.contact = {time, kind, vertices};
  // The common frame has a's orientation at the start, and its origin moves with a's.
  const Motion& motion = a_.motion;
  const auto origin = [&](const Eigen::Isometry3d& pose) {
    return Placement(pose, motion.scale).origin(a_.part->frame);
  };
  const Vector rounder = 0.5 * (scale_b * b_.part->convex_radius - scale_a * a_.part->convex_radius) * normal;
  ranked.contact.point = motion.start.linear() * (0.5 * (meeting.on_a + meeting.on_b) + rounder) +
                         ((1 - time) * origin(motion.start) + time * origin(motion.end));
  ranked.contact.normal = (motion.start.linear() * normal).normalized();

  const auto better = [](const Ranked& x, const Ranked& y) {
    const auto key = [](const Ranked& r) {
      return std::tie(r.rank.unsupported, r.rank.distance, r.rank.receding, r.rank.averted, r.contact.time,
                      r.contact.kind, r.contact.vertices);
    };
    return key(x) < key(y);
  };
  if (!first_ || time < first_->time) {
    const double later = first_ ? (first_->time - time) / tick : window + 1;
    const int shift = static_cast<int>(std::min<double>(later, window + 1));
    std::move_backward(best_.begin(), best_.end() - shift, best_.end());
    std::fill(best_.begin(), best_.begin() + shift, std::nullopt);
    first_.emplace().time = time;
    latest_ = std::min(options_.latest, ignores_ties_ ? time - tick : time + window * tick);
  }
  auto& slot = best_[static_cast<std::size_t>((time - first_->time) / tick)];
  if (!slot || better(ranked, *slot)) slot = ranked;
  const Ranked* best = nullptr;
  for (const auto& candidate : best_) {
    if (candidate && (best == nullptr || better(*candidate, *best))) best = &*candidate;
  }
  const double earliest = first_->time;
  first_ = best->contact;
  first_->time = earliest;
  first_->overlapping = overlapping_;
  first_->exhausted = exhausted_;
}

/// Two triangles that cross touch at the start, although their features may be apart: a corner of one is beyond the
/// other one.
void PairContact::note_crossing(const Triangles& triangles, const std::array<std::int32_t, 3>& vertices_a,
                                const std::array<std::int32_t, 3>& vertices_b) noexcept {
  const TriangleD &a = triangles.a.start, &b = triangles.b.start;
  if (beside(a, b) || beside(b, a) || !triangles_cross(a, b, rounding_)) return;
  overlapping_ = true;
  const Vector up = (b[1] - b[0]).cross(b[2] - b[0]);
  int deepest = 0;
  for (int k = 1; k < 3; ++k) {
    if (up.dot(a[k] - a[deepest]) < 0) deepest = k;
  }
  const MovingTriangle& face = triangles.b;
  const MovingPoints points = {{a[deepest], face.start[0], face.start[1], face.start[2]},
                               {triangles.a.end[deepest], face.end[0], face.end[1], face.end[2]}};
  add({0,
       ContactKind::vertex_face,
       sorted(vertices_a[deepest], vertices_b),
       meet_vertex_face(points, 0, true),
       {a, b}});
}

/// Leaves out contacts that are not earlier than the first one. There must be one.
void PairContact::ignore_ties() noexcept {
  ignores_ties_ = exhausted_ = true;
  first_->exhausted = true;
  latest_ = std::min(options_.latest, first_->time - tick);
}

/// Makes `time`, a multiple of 2^-22, the time of first contact if it is not later than that. If there is no contact
/// yet, it becomes that of the nearest features of two triangles.
void PairContact::suppose(std::int32_t triangle_a, std::int32_t triangle_b, double time) {
  exhausted_ = true;
  if (!first_) {
    turn_to(triangle_a, triangle_b);
    Placed a = placed(a_, triangle_a), b = placed(b_, triangle_b);
    a.owned = b.owned = ~0U;
    const CornerPair corners = {at(a.triangle, time), at(b.triangle, time)};
    double least = std::numeric_limits<double>::infinity();
    std::optional<Found> nearest;
    for_each_feature_pair(
        a, b, [&](ContactKind kind, const MovingPoints& points, const std::array<std::int32_t, 4>& vertices) {
          const Meeting meeting = meet(kind, points, time);
          const double squared = (meeting.on_a - meeting.on_b).squaredNorm();
          if (nearest && !(squared < least)) return;
          least = squared;
          nearest = {time, kind, vertices, meeting, corners};
        });
    add(*nearest);
  } else if (time < first_->time) {
    // The best features so far remain so.
    const auto best = std::find_if(best_.begin(), best_.end(), [&](const std::optional<Ranked>& ranked) {
      return ranked && ranked->contact.kind == first_->kind && ranked->contact.vertices == first_->vertices;
    });
    Ranked kept = **best;
    kept.contact.time = time;
    best_.fill(std::nullopt);
    best_[0] = kept;
    first_->time = time;
  }
  ignore_ties();
}

}  // namespace encage
