// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/contact_search.h"

#include "broadphase/distance/triangle_distance.h"
#include "broadphase/separation/box_gate.h"
#include "broadphase/separation/containment.h"
#include "src/mesh/segments.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;
using Where = ContactScratch::Where;

/// Radians by which a direction may leave a feature's Voronoi region.
constexpr double region_slack = 1e-3;
/// The same for round bodies, whose directions are those of nearest points.
constexpr double round_slack = 1e-7;
/// Least ratio of the length of a patch's vector area to its area at which the vector tells the side it entered by.
constexpr double coherent = 0.85;
/// Cosine of the angle between the faces of an edge that approximates a smooth surface.
constexpr double blunt_cosine = 0.85;
/// Vertices that are searched for inwards, of one body of a pair. What is deeper counts no more.
constexpr std::size_t most_flooded = 4096;
/// Pairs of leaves that are looked at. Bodies that rest on each other have some thousands; dense surfaces that lie in
/// each other over and over have millions, of which the first ones tell enough of a depth that is heuristic anyway.
constexpr std::size_t most_leaf_pairs = 1 << 16;
/// Searches for a way out by the directions of faces, which visit much of a mesh where few faces have them.
constexpr int most_searches = 1024;
/// Pairs of an edge crossing and a contact that are compared, the deepest crossings first.
constexpr std::size_t most_compared = 1 << 23;

std::uint64_t vertex_feature(const ContactBody& guest, const ContactBody& host, bool guest_is_a, std::int32_t v) {
  return static_cast<std::uint64_t>(guest_is_a ? 0 : 1) << 62 |
         static_cast<std::uint64_t>(static_cast<std::uint32_t>(host.part) & 0x3fffffffU) << 32 |
         static_cast<std::uint32_t>(guest.first_vertex + v);
}

class Search {
 public:
  Search(ContactScratch& scratch, const ContactQuery& query, ContactMemory* memory)
      : s_(scratch),
        motion_(query.motion),
        limit_(query.limit),
        error_(query.error),
        sides_(query.sides),
        new_sides_(query.new_sides),
        with_last_resort_(query.with_last_resort),
        memory_(memory) {
    s_.leaf_pairs.clear();
    s_.crossings.clear();
    for (ContactBody* body : {&s_.a, &s_.b}) {
      body->leaf_index.clear(body->surface->tree.leaves.size());
      body->vertex_index.clear(body->mesh.vertices.size());
      body->leaves.clear();
      body->vertices.clear();
      body->edges.clear();
    }
    far_ += query.approach;
    if (memory == nullptr || memory->reach <= 0) return;
    far_ += memory->reach;
    wide_ = limit_ + memory->reach;
    turn_ = memory->reach / std::min(s_.a.scale * s_.a.surface->radius, s_.b.scale * s_.b.surface->radius);
  }

  void run() {
    const std::size_t first = s_.candidates.size();
    const Surface &a = *s_.a.surface, &b = *s_.b.surface;
    const BoxGate gate(motion_, {a.radius, a.tree.grid, s_.a.scale}, {b.radius, b.tree.grid, s_.b.scale},
                       wide_ + error_);
    visit_leaf_pairs(
        a.tree, b.tree, gate,
        [](void* self, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
          return static_cast<Search*>(self)->leaves(first_a, count_a, first_b, count_b);
        },
        this);
    if (!s_.leaf_pairs.empty()) {
      vertices_of(s_.a, s_.b, true, false);
      vertices_of(s_.b, s_.a, false, false);
      add_crossings(first);
    }
    if (s_.candidates.size() == first) vertices_of(s_.a, s_.b, true, true);
    if (s_.candidates.size() == first) vertices_of(s_.b, s_.a, false, true);
    if (s_.candidates.size() == first && with_last_resort_) last_resort(first);
  }

  void run_again(const ContactMemory& memory, double approach) {
    again_ = true;
    const std::size_t first = s_.candidates.size();
    again(s_.a, s_.b, true, memory.vertices_a, approach);
    again(s_.b, s_.a, false, memory.vertices_b, approach);
    for (const ContactMemory::Edges& pair : memory.edges) {
      if (pair.distance - approach > limit_) continue;
      ContactEdge a, b;
      if (edge_at(s_.a, pair.a, a) && edge_at(s_.b, pair.b, b)) edge_pair(a, b);
    }
    add_crossings(first);
  }

 private:
  /// Returns false where the budget ends.
  bool leaves(std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
    const std::int32_t index_a = s_.a.leaf(first_a, count_a), index_b = s_.b.leaf(first_b, count_b);
    s_.leaf_pairs.push_back({index_a, index_b});
    const ContactLeaf &a = s_.a.leaves[static_cast<std::size_t>(index_a)],
                      &b = s_.b.leaves[static_cast<std::size_t>(index_b)];
    note_nearest(b, vertices(s_.a, a), far_);
    note_nearest(a, vertices(s_.b, b), far_);
    for (const ContactEdges& of_a : edges(s_.a, a)) {
      for (const ContactEdges& of_b : edges(s_.b, b)) {
        for (int i = 0; i < ContactEdges::width && of_a.length[static_cast<std::size_t>(i)] > 0; ++i) {
          for (std::uint32_t left = edges_may_meet(of_a, i, of_b, region_slack + turn_); left != 0; left &= left - 1) {
            edge_pair(edge_in(of_a, i), edge_in(of_b, __builtin_ctz(left)));
          }
        }
      }
    }
    if (s_.a.round) local_minima(s_.a, a, s_.b, b, true);
    if (s_.b.round) local_minima(s_.b, b, s_.a, a, false);
    return s_.leaf_pairs.size() < most_leaf_pairs;
  }

  static std::span<ContactVertex> vertices(ContactBody& body, const ContactLeaf& leaf) {
    return std::span(body.vertices)
        .subspan(static_cast<std::size_t>(leaf.first_vertex), static_cast<std::size_t>(leaf.vertex_count));
  }
  static std::span<const ContactEdges> edges(const ContactBody& body, const ContactLeaf& leaf) {
    return std::span(body.edges)
        .subspan(static_cast<std::size_t>(leaf.first_edges), static_cast<std::size_t>(leaf.edge_blocks));
  }

  static ContactEdge edge_in(const ContactEdges& edges, int lane) {
    const auto at = static_cast<std::size_t>(lane);
    const auto vector = [&](const ContactEdges::Vectors& v) { return Vector(v[0][at], v[1][at], v[2][at]); };
    return {vector(edges.start),
            vector(edges.along),
            {vector(edges.out[0]), vector(edges.out[1])},
            edges.length[at],
            edges.side[at]};
  }
  static bool edge_at(const ContactBody& body, std::int32_t side, ContactEdge& edge) {
    const std::int32_t t = side / 3;
    return body.edge(t, side % 3, body.triangle(t), body.face_normal(t), edge);
  }

  /// True if `direction`, at right angles to the edge, stays in its region.
  static bool in_region(const ContactEdge& edge, const Vector& direction, double slack) {
    return edge.out[0].dot(direction) >= -slack && edge.out[1].dot(direction) >= -slack;
  }

  /// Two edges meet if a common perpendicular leads from b's edge outwards, and back to a's (Gauss map).
  void edge_pair(const ContactEdge& a, const ContactEdge& b) {
    Vector n = a.along.cross(b.along);
    const double length = n.norm();
    if (!(length > 1e-4 * a.length * b.length)) return;
    const auto meet = [&](double slack, const Vector& way) {
      return in_region(b, way, slack * length) && in_region(a, -way, slack * length);
    };
    const bool near_forth = meet(region_slack + turn_, n), near_back = meet(region_slack + turn_, -n);
    if (!near_forth && !near_back) return;
    const auto [s, t] = closest_parameters(a.along, b.along, a.start - b.start);
    const Vector on_a = a.start + s * a.along, on_b = b.start + t * b.along;
    const Vector apart = on_a - on_b;
    const double depth = std::min(a.length, b.length);
    if (memory_ != nullptr && wide_ > limit_ && apart.norm() <= depth + wide_)
      memory_->edges.push_back({a.side, b.side, apart.norm() - depth});
    const bool forth = turn_ > 0 ? meet(region_slack, n) : near_forth,
               back = turn_ > 0 ? meet(region_slack, -n) : near_back;
    if (!forth && !back) return;
    if (!(s > 0 && s < 1 && t > 0 && t < 1)) return;
    n /= forth && (!back || n.dot(apart) > 0) ? length : -length;
    ContactCandidate c;
    c.point_a = on_a;
    c.point_b = on_b;
    c.normal = n;
    c.separation = n.dot(apart);
    if (c.separation > limit_ && !(c.separation <= reach(s_.a.displacement(on_a), n))) return;
    c.feature = std::uint64_t{2} << 62 | static_cast<std::uint64_t>(3 * s_.a.first_triangle + a.side) << 31 |
                static_cast<std::uint64_t>(3 * s_.b.first_triangle + b.side);
    if (c.separation >= 0) {
      s_.candidates.push_back(c);
    } else if (c.separation > -depth) {
      const auto blunt = [](const ContactEdge& edge) { return -edge.out[0].dot(edge.out[1]) > blunt_cosine; };
      s_.crossings.push_back({c, a.side, b.side, blunt(a) && blunt(b)});
    }
  }

  void add(const ContactBody& guest, const ContactBody& host, bool guest_is_a, const ContactVertex& v,
           const Vector& on_host, const Vector& normal, double separation) {
    if (separation > limit_ && !(separation <= reach(guest.displacement(v.position), normal))) return;
    if (normal.isZero()) return;  // degenerate triangles tell no direction
    ContactCandidate c;
    c.point_a = guest_is_a ? v.position : on_host;
    c.point_b = guest_is_a ? on_host : v.position;
    c.normal = guest_is_a ? normal : Vector(-normal);
    c.separation = separation;
    c.feature = vertex_feature(guest, host, guest_is_a, v.vertex);
    s_.candidates.push_back(c);
  }

  /// Locates the vertices near the other body, finds those inside it, and makes contacts of both. With `anywhere` it
  /// starts from any vertex of each part of the guest, which may be wholly inside the host.
  void vertices_of(ContactBody& guest, ContactBody& host, bool guest_is_a, bool anywhere) {
    s_.located.clear();
    s_.located.resize(guest.vertices.size());
    if (anywhere && !(host.solid && locate_parts(guest, host))) return;
    for (std::size_t i = 0; i < guest.vertices.size(); ++i) {
      const ContactVertex& v = guest.vertices[i];
      if (reaches(guest, v, v.any)) locate(host, v, v.any_triangle, s_.located[i]);
    }
    if (host.solid) {
      if (!anywhere && guest.features->part_sides.size() > 1) locate_parts(guest, host);
      locate_crossing(guest, host, guest_is_a);
      flood(guest, host, guest_is_a);
    }
    contacts_of_located(guest, host, guest_is_a);
    if (memory_ != nullptr && wide_ > limit_) remember(guest, guest_is_a);
  }

  void contacts_of_located(const ContactBody& guest, const ContactBody& host, bool guest_is_a) {
    for (std::size_t i = 0; i < guest.vertices.size(); ++i) {
      const ContactVertex& v = guest.vertices[i];
      if (guest.surface->is_foreign(v.vertex)) continue;
      switch (s_.located[i].where) {
        case Where::outside:
          if (reaches(guest, v, v.any)) outside(guest, host, guest_is_a, v, s_.located[i].nearest);
          break;
        case Where::inside: inside(guest, host, guest_is_a, v, s_.located[i]); break;
        case Where::unknown: break;
      }
    }
  }

  void remember(const ContactBody& guest, bool guest_is_a) {
    auto& vertices = guest_is_a ? memory_->vertices_a : memory_->vertices_b;
    vertices.clear();
    for (std::size_t i = 0; i < guest.vertices.size(); ++i) {
      const ContactVertex& v = guest.vertices[i];
      const ContactScratch::Located& located = s_.located[i];
      if (located.where == Where::unknown || (located.where == Where::outside && !reaches(guest, v, v.any))) continue;
      const std::int32_t facing = located.way_out >= 0 ? located.way_out : v.facing_triangle;
      const double distance = located.where == Where::inside ? 0 : std::sqrt(v.any);
      vertices.push_back({v.side, located.nearest.triangle, facing, distance});
    }
  }

  /// Looks at the vertices that are remembered and may be near by now. Nearest triangles are mostly those of then, or
  /// beside them, which bounds the search for what is nearer. The triangle through which a vertex inside leaves is that
  /// of then, or beside it.
  void again(ContactBody& guest, const ContactBody& host, bool guest_is_a,
             std::span<const ContactMemory::Vertex> vertices, double approach) {
    s_.located.clear();
    for (const ContactMemory::Vertex& remembered : vertices) {
      if (remembered.distance - approach > limit_) continue;
      guest.vertex(remembered.side / 3, remembered.side % 3);
      ContactVertex& v = guest.vertices.back();
      const Vector p = host.inverse(v.position);
      ContactScratch::Located& located = s_.located.emplace_back();
      located.nearest = nearest_on(host, p, remembered.nearest);
      SurfacePoint nearer;
      if (nearest_point(*host.surface, p, located.nearest.distance, nearer)) located.nearest = nearer;
      v.any = std::pow(located.nearest.distance * host.scale, 2);
      v.any_triangle = located.nearest.triangle;
      if (remembered.facing >= 0) {
        const SurfacePoint facing = descend(host, p, remembered.facing, [&](std::int32_t t) {
          return v.normal.dot(host.face_normal(t)) < v.most_cosine;
        });
        v.facing = std::pow(facing.distance * host.scale, 2);
        v.facing_triangle = facing.triangle;
      }
      set_side(host, p, v, located);
    }
    contacts_of_located(guest, host, guest_is_a);
  }

  /// Walks over triangles that pass the filter to a point that is nearer to p than all around it.
  template <class Filter>
  static SurfacePoint descend(const ContactBody& host, const Vector& p, std::int32_t start, const Filter& passes) {
    constexpr int most_steps = 16;
    SurfacePoint best = nearest_on(host, p, start);
    for (int step = 0; step < most_steps && best.kind != SurfacePoint::Kind::face; ++step) {
      const SurfacePoint from = best;
      const auto consider = [&](std::int32_t t) {
        if (t == from.triangle || !passes(t)) return;
        const SurfacePoint point = nearest_on(host, p, t);
        if (point.distance < best.distance) best = point;
      };
      if (from.kind == SurfacePoint::Kind::vertex) {
        visit_around(*host.features, from.triangle, from.corner, consider);
      } else {
        const std::int32_t twin = host.features->twin_of(3 * from.triangle + from.corner);
        if (twin >= 0) consider(twin / 3);
      }
      if (best.triangle == from.triangle) break;
    }
    return best;
  }

  static SurfacePoint nearest_on(const ContactBody& host, const Vector& p, std::int32_t triangle) {
    const auto corner = [&](int k) { return host.local_vertex(host.vertex_number(triangle, k)); };
    SurfacePoint point = nearest_in_triangle(p, {corner(0), corner(1), corner(2)});
    point.triangle = triangle;
    return point;
  }

  /// Takes the nearest triangle.
  void locate(const ContactBody& host, const ContactVertex& v, std::int32_t triangle,
              ContactScratch::Located& located) const {
    const Vector p = host.inverse(v.position);
    located.nearest = nearest_on(host, p, triangle);
    set_side(host, p, v, located);
  }

  /// A vertex on the surface that looks the same way as the surface does belongs to a body that has entered.
  void set_side(const ContactBody& host, const Vector& p, const ContactVertex& v,
                ContactScratch::Located& located) const {
    located.where = Where::outside;
    if (!host.solid) return;
    const Vector out = feature_normal(*host.surface, *host.features, located.nearest);
    const bool on_surface = located.nearest.distance * host.scale <= 4 * error_;
    const bool behind =
        on_surface ? host.direction(out).dot(v.normal) > -facing_cosine : out.dot(p - located.nearest.point) < 0;
    if (behind) located.where = Where::inside;
  }

  /// Locates one vertex of each part of the guest within the host's box: a part may be inside without touching the
  /// host's surface. False if there is none.
  bool locate_parts(ContactBody& guest, const ContactBody& host) {
    bool any = false;
    for (const std::int32_t side : guest.features->part_sides) {
      const Vector p = host.inverse(guest.position(side / 3, side % 3));
      if ((p.array() < host.surface->lower.cast<double>().array()).any() ||
          (p.array() > host.surface->upper.cast<double>().array()).any()) {
        continue;
      }
      any = true;
      const auto v = static_cast<std::size_t>(guest.vertex(side / 3, side % 3));
      if (v >= s_.located.size()) s_.located.resize(v + 1);
      if (s_.located[v].where != Where::unknown) continue;
      locate_anywhere(host, guest.vertices[v], s_.located[v]);
      // Normals tell nothing next to faces that coincide.
      const Side side_of_host = encage::locate(*host.surface, p);
      if (side_of_host == Side::inside) s_.located[v].where = Where::inside;
      if (side_of_host == Side::outside) s_.located[v].where = Where::outside;
    }
    return any;
  }

  void locate_anywhere(const ContactBody& host, const ContactVertex& v, ContactScratch::Located& located) const {
    const Vector p = host.inverse(v.position);
    if (nearest_point(*host.surface, p, std::numeric_limits<double>::infinity(), located.nearest)) {
      set_side(host, p, v, located);
    }
  }

  /// Locates the corners, beyond the limit, of triangles that cross the host.
  void locate_crossing(ContactBody& guest, const ContactBody& host, bool guest_is_a) {
    std::int32_t last = -1;
    bool open = false;
    for (const ContactScratch::LeafPair& pair : s_.leaf_pairs) {
      const std::int32_t on_guest = guest_is_a ? pair.a : pair.b, on_host = guest_is_a ? pair.b : pair.a;
      const ContactLeaf& leaf = guest.leaves[static_cast<std::size_t>(on_guest)];
      if (on_guest != last) open = has_unlocated(guest, leaf);
      last = on_guest;
      if (!open) continue;
      const ContactLeaf& other = host.leaves[static_cast<std::size_t>(on_host)];
      for (int i = 0; i < leaf.count; ++i) {
        std::uint32_t left = may_touch(leaf, i, other, error_);
        if (left == 0) continue;
        const std::int32_t t = leaf.triangle[static_cast<std::size_t>(i)];
        const TriangleD own = guest.triangle(t);
        for (; left != 0; left &= left - 1) {
          const auto j = static_cast<std::size_t>(__builtin_ctz(left));
          if (!triangles_cross(own, host.triangle(other.triangle[j]), 0)) continue;
          for (int k = 0; k < 3; ++k) {
            const auto v = static_cast<std::size_t>(guest.vertex(t, k));
            if (v >= s_.located.size()) s_.located.resize(v + 1);
            if (s_.located[v].where == Where::unknown) locate_anywhere(host, guest.vertices[v], s_.located[v]);
          }
          open = has_unlocated(guest, leaf);
          break;
        }
      }
    }
  }

  bool has_unlocated(ContactBody& guest, const ContactLeaf& leaf) const {
    for (int i = 0; i < leaf.count; ++i) {
      for (int k = 0; k < 3; ++k) {
        const std::int32_t v = guest.vertex_index[guest.vertex_number(leaf.triangle[static_cast<std::size_t>(i)], k)];
        if (v < 0 || static_cast<std::size_t>(v) >= s_.located.size() ||
            s_.located[static_cast<std::size_t>(v)].where == Where::unknown) {
          return true;
        }
      }
    }
    return false;
  }

  /// Finds the vertices inside the host that hang together with those found, and groups them.
  void flood(ContactBody& guest, const ContactBody& host, bool guest_is_a) {
    s_.patches.clear();
    std::size_t searched = 0;
    for (std::size_t seed = 0; seed < s_.located.size(); ++seed) {
      if (s_.located[seed].where != Where::inside || s_.located[seed].patch >= 0) continue;
      const auto number = static_cast<std::int32_t>(s_.patches.size());
      s_.patches.emplace_back();
      s_.queue.clear();
      s_.queue.push_back(static_cast<std::int32_t>(seed));
      s_.located[seed].patch = number;
      for (std::size_t next = 0; next < s_.queue.size(); ++next) {
        const ContactVertex& entered = guest.vertices[static_cast<std::size_t>(s_.queue[next])];
        const std::int32_t side = entered.side;
        if (const Vector* const before = side_before(vertex_feature(guest, host, guest_is_a, entered.vertex))) {
          s_.patches.back().before += host.direction(*before);
          ++s_.patches.back().remembered;
        }
        visit_around(*guest.features, side / 3, side % 3, [&](std::int32_t t) {
          const TriangleD corners = guest.triangle(t);
          const Vector area = (corners[1] - corners[0]).cross(corners[2] - corners[0]) / 6;
          ContactScratch::Patch& patch = s_.patches.back();
          patch.area += area;
          patch.size += area.norm();
          for (int k = 0; k < 3; ++k) {
            const auto v = static_cast<std::size_t>(guest.vertex(t, k));
            if (v >= s_.located.size()) s_.located.resize(v + 1);
            ContactScratch::Located& located = s_.located[v];
            if (located.where == Where::unknown && searched < most_flooded) {
              ++searched;
              locate_anywhere(host, guest.vertices[v], located);
            }
            if (located.where != Where::inside || located.patch >= 0) continue;
            located.patch = number;
            s_.queue.push_back(static_cast<std::int32_t>(v));
          }
        });
      }
    }
  }

  void outside(const ContactBody& guest, const ContactBody& host, bool guest_is_a, const ContactVertex& v,
               const SurfacePoint& nearest) {
    if (guest.round) return;                                               // see local_minima()
    if (host.round && nearest.kind == SurfacePoint::Kind::vertex) return;  // likewise
    const Vector on_host = host.map(nearest.point);
    const Vector away = v.position - on_host;
    const double distance = away.norm();
    if (!host.solid && !host.round) {
      if (host.is_tile() && is_of_other_tile(host, v, nearest)) return;
      two_sided(guest, host, guest_is_a, v, nearest);
      return;
    }
    if (distance <= 4 * error_) {
      Vector normal;
      if (facing_faces(guest, v, host, nearest, normal)) add(guest, host, guest_is_a, v, on_host, normal, distance);
      return;
    }
    const Vector normal = away / distance;
    if (may_point(guest, host, v, nearest, normal)) {
      if (host.round && !in_vertex_region(guest, v, -normal, round_slack)) return;
      add(guest, host, guest_is_a, v, on_host, normal, distance);
      return;
    }
    // The nearest triangle looks away: the one that faces the vertex, if the vertex is above it.
    if (!reaches(guest, v, v.facing)) return;
    const TriangleD triangle = host.triangle(v.facing_triangle);
    const SurfacePoint facing = nearest_in_triangle(v.position, triangle);
    const Vector up = v.position - facing.point;
    const double height = up.norm();
    if (facing.kind != SurfacePoint::Kind::face || !(unit_normal(triangle).dot(up) > 0)) return;
    if (!faces(guest, v, up / height)) return;
    add(guest, host, guest_is_a, v, facing.point, up / height, height);
  }

  /// True if the point of a tile that is nearest to a vertex lies on a feature that another tile owns, or if that tile
  /// has a nearer point: the contact is then the other tile's, or none. The normal of this one would be askew.
  bool is_of_other_tile(const ContactBody& host, const ContactVertex& v, const SurfacePoint& nearest) const {
    if (nearest.kind == SurfacePoint::Kind::face) return false;
    const Vector p = host.inverse(v.position);
    const double nearer = nearest.distance - 4 * error_ / host.scale;
    bool other = false;
    const auto compare = [&](std::int32_t t) {
      other = other || (!host.is_own(t) && nearest_on(host, p, t).distance < nearer);
    };
    if (nearest.kind == SurfacePoint::Kind::vertex) {
      visit_around(*host.features, nearest.triangle, nearest.corner, compare);
      return other || host.surface->is_foreign(host.vertex_number(nearest.triangle, nearest.corner));
    }
    const std::int32_t twin = host.features->twin_of(3 * nearest.triangle + nearest.corner);
    if (twin < 0 || host.is_own(twin / 3)) return false;
    compare(twin / 3);
    const unsigned owned = host.surface->owned[static_cast<std::size_t>(nearest.triangle)];
    return other || (owned >> (3 + static_cast<unsigned>(nearest.corner)) & 1U) == 0;
  }

  /// True if the normal, which leads from the nearest point to the vertex, stays in the vertex's region, or is that of
  /// a face which the vertex faces: then it holds wherever the vertex is. Normals of edges and vertices do not, and
  /// would point askew next to bodies that rest on a plane.
  static bool may_point(const ContactBody& guest, const ContactBody& host, const ContactVertex& v,
                        const SurfacePoint& nearest, const Vector& normal) {
    const bool upright = std::abs(host.face_normal(nearest.triangle).dot(normal)) > 1 - 1e-9;
    return (upright && faces(guest, v, normal)) || in_vertex_region(guest, v, -normal);
  }
  static bool faces(const ContactBody& guest, const ContactVertex& v, const Vector& normal) {
    if (guest.solid) return v.normal.dot(normal) < v.most_cosine;
    const Eigen::Vector3f& own = guest.features->vertex_normal[static_cast<std::size_t>(v.vertex)];
    return std::abs(guest.direction(own.cast<double>()).dot(normal)) > -facing_cosine;
  }

  /// A vertex and a surface without interior: the side is that of the step before, or the one that the vertex's own
  /// normal faces.
  void two_sided(const ContactBody& guest, const ContactBody& host, bool guest_is_a, const ContactVertex& v,
                 const SurfacePoint& nearest) {
    const Vector on_host = host.map(nearest.point), away = v.position - on_host;
    const double distance = away.norm();
    const Vector face = unit_normal(host.triangle(nearest.triangle));
    Vector normal = distance > 4 * error_ ? Vector(away / distance) : face;
    const std::uint64_t feature = vertex_feature(guest, host, guest_is_a, v.vertex);
    const Vector* before = side_before(feature);
    if (before == nullptr && host.is_tile()) before = side_on_any_part(feature);
    const double wanted = before != nullptr ? host.direction(*before).dot(normal) : -v.normal.dot(normal);
    double separation = distance;
    const bool touches = distance <= 4 * error_;
    if (before != nullptr || guest.solid) {
      if (touches && std::abs(wanted) < -facing_cosine) return;
      if (wanted < facing_cosine) {
        if (std::abs(face.dot(normal)) < 0.7) return;  // beyond the boundary
        const bool near = before != nullptr || touches;
        if (near || (distance <= limit_ && crosses(guest, v, host.triangle(nearest.triangle)))) {
          normal = -normal;
          separation = -distance;
        }
      }
    }
    if (!may_point(guest, host, v, nearest, normal)) return;
    add(guest, host, guest_is_a, v, on_host, normal, separation);
    if (!normal.isZero()) new_sides_.push_back({feature, host.local_direction(normal).cast<float>()});
  }

  /// True if a face at the vertex crosses the triangle.
  static bool crosses(const ContactBody& guest, const ContactVertex& v, const TriangleD& triangle) {
    bool any = false;
    visit_around(*guest.features, v.side / 3, v.side % 3,
                 [&](std::int32_t t) { any = any || triangles_cross(guest.triangle(t), triangle, 0); });
    return any;
  }

  /// True if points that `direction` leads to have the vertex as their nearest feature.
  static bool in_vertex_region(const ContactBody& body, const ContactVertex& v, const Vector& direction,
                               double slack = region_slack) {
    bool in = true;
    visit_around(*body.features, v.side / 3, v.side % 3, [&](std::int32_t t) {
      for (int k = 0; k < 3; ++k) {
        const Vector along = body.position(t, k) - v.position;
        in = in && along.dot(direction) <= slack * along.norm();
      }
    });
    return in;
  }

  /// Of features that touch, the normal of the two faces that face each other most; false if none do.
  static bool facing_faces(const ContactBody& guest, const ContactVertex& v, const ContactBody& host,
                           const SurfacePoint& point, Vector& normal) {
    double least = facing_cosine;
    const auto compare = [&](std::int32_t on_host) {
      const Vector up = unit_normal(host.triangle(on_host));
      visit_around(*guest.features, v.side / 3, v.side % 3, [&](std::int32_t on_guest) {
        const double cosine = up.dot(unit_normal(guest.triangle(on_guest)));
        if (cosine >= least) return;
        least = cosine;
        normal = up;
      });
    };
    if (point.kind == SurfacePoint::Kind::vertex) {
      visit_around(*host.features, point.triangle, point.corner, compare);
    } else {
      compare(point.triangle);
      const std::int32_t twin = host.features->twin_of(3 * point.triangle + point.corner);
      if (point.kind == SurfacePoint::Kind::edge && twin >= 0) compare(twin / 3);
    }
    return least < facing_cosine;
  }

  const Vector* side_before(std::uint64_t feature) {
    const auto found = std::lower_bound(sides_.begin(), sides_.end(), feature,
                                        [](const ContactSide& side, std::uint64_t f) { return side.feature < f; });
    if (found == sides_.end() || found->feature != feature) return nullptr;
    before_ = found->normal.cast<double>();
    return &before_;
  }

  /// The same where the vertex was near another tile.
  const Vector* side_on_any_part(std::uint64_t feature) {
    constexpr std::uint64_t part = std::uint64_t{0x3fffffff} << 32;
    const auto found = std::find_if(sides_.begin(), sides_.end(), [&](const ContactSide& side) {
      return (side.feature & ~part) == (feature & ~part);
    });
    if (found == sides_.end()) return nullptr;
    before_ = found->normal.cast<double>();
    return &before_;
  }

  /// The mean side of the vertices around one in the query before, unless they differ much. 0 if they had none.
  Vector side_around(const ContactBody& guest, const ContactBody& host, bool guest_is_a, const ContactVertex& v) {
    Vector sum = Vector::Zero();
    int count = 0;
    visit_around(*guest.features, v.side / 3, v.side % 3, [&](std::int32_t t) {
      for (int k = 0; k < 3; ++k) {
        const std::int32_t other = guest.vertex_number(t, k);
        if (other == v.vertex) continue;
        const Vector* const before = side_before(vertex_feature(guest, host, guest_is_a, other));
        if (before == nullptr) continue;
        sum += *before;
        ++count;
      }
    });
    const double length = sum.norm();
    return count > 0 && length > 0.5 * count ? host.direction(sum / length) : Vector(Vector::Zero());
  }

  /// The side of the patch in the query before. Patches may run around threads and rings: those count for vertices that
  /// look against their common side only, others follow the vertices around them.
  Vector side_of_patch(const ContactBody& guest, const ContactBody& host, bool guest_is_a, const ContactVertex& v,
                       const ContactScratch::Located& located) {
    if (located.patch >= 0) {
      const ContactScratch::Patch& patch = s_.patches[static_cast<std::size_t>(located.patch)];
      const double length = patch.before.norm();
      if (length > 0.3 * patch.remembered && patch.before.dot(v.normal) < -facing_cosine * length) {
        return patch.before / length;
      }
    }
    return side_around(guest, host, guest_is_a, v);
  }

  /// A vertex inside: the way out is the nearest face that faces the vertex, the patch it belongs to, and the side by
  /// which it was pushed out before.
  void inside(const ContactBody& guest, const ContactBody& host, bool guest_is_a, const ContactVertex& v,
              ContactScratch::Located& located) {
    const Vector p = host.inverse(v.position);
    SurfacePoint out;
    const auto search = [&](const Vector& against, double most) {
      if (++searches_ > most_searches) return false;
      SurfacePoint found;
      const NormalFilter filter{host.local_direction(against), most};
      if (!nearest_point(*host.surface, p, std::numeric_limits<double>::infinity(), found, filter)) return false;
      out = found;
      return true;
    };
    const auto face = [&] { return unit_normal(host.triangle(out.triangle)); };
    if (!guest.solid && !guest.round) {
      // Either side of a sheet may face the way out.
      const Eigen::Vector3f& own = guest.features->vertex_normal[static_cast<std::size_t>(v.vertex)];
      const Vector axis = guest.direction(own.cast<double>());
      out = located.nearest;
      SurfacePoint one;
      const bool found = search(axis, facing_cosine);
      if (found) one = out;
      if (search(-axis, facing_cosine) && found && one.distance < out.distance) out = one;
    } else if (v.facing <= wide_ * wide_ || (again_ && v.facing_triangle >= 0)) {
      out = nearest_on(host, p, v.facing_triangle);
    } else {
      // What faces a vertex on the side of a bar may be the bar's far end.
      const bool found = v.most_cosine < 1 && search(v.normal, facing_cosine);
      const bool far = found && out.distance > 2 * located.nearest.distance &&
                       unit_normal(host.triangle(located.nearest.triangle)).dot(v.normal) < -facing_cosine;
      if (!found || far) out = located.nearest;
    }
    if (guest.solid && located.patch >= 0) {
      const ContactScratch::Patch& patch = s_.patches[static_cast<std::size_t>(located.patch)];
      const double length = patch.area.norm();
      if (length > coherent * patch.size) {
        const Vector way = patch.area / length;
        if (face().dot(way) > facing_cosine) search(way, facing_cosine);
      }
    }
    const std::uint64_t feature = vertex_feature(guest, host, guest_is_a, v.vertex);
    // A vertex that has just entered takes the side of those around it; and these keep one from turning round little by
    // little.
    Vector side = Vector::Zero();
    if (const Vector* const before = side_before(feature)) side = host.direction(*before);
    side += 2 * side_of_patch(guest, host, guest_is_a, v, located);
    side.stableNormalize();
    if (face().dot(side) < -facing_cosine && !side.isZero()) search(-side, facing_cosine);
    located.way_out = out.triangle;
    Vector normal = face();
    const Vector to_surface = host.map(out.point) - v.position;
    double depth = to_surface.norm();
    if (depth > 4 * error_ && to_surface.dot(normal) > 0.9 * depth) {
      normal = to_surface / depth;
    } else {
      depth = std::max(0.0, to_surface.dot(normal));
    }
    add(guest, host, guest_is_a, v, v.position + depth * normal, normal, -depth);
    new_sides_.push_back({feature, host.local_direction(normal).cast<float>()});
  }

  /// A round body touches all features of the host in whose regions its vertices are.
  void local_minima(ContactBody& guest, const ContactLeaf& leaf, const ContactBody& host, const ContactLeaf& other,
                    bool guest_is_a) {
    for (const ContactVertex& v : vertices(guest, leaf)) {
      for (int i = 0; i < other.count; ++i) {
        const std::int32_t t = other.triangle[static_cast<std::size_t>(i)];
        const TriangleD triangle = host.triangle(t);
        SurfacePoint point = nearest_in_triangle(v.position, triangle);
        point.triangle = t;
        if (!reaches(guest, v, point.distance * point.distance) || point.distance <= 4 * error_) continue;
        const Vector normal = (v.position - point.point) / point.distance;
        if (!host_feature_holds(host, point, normal)) continue;
        const std::size_t count = s_.candidates.size();
        add(guest, host, guest_is_a, v, point.point, normal, point.distance);
        // The same vertex may touch several features.
        if (s_.candidates.size() > count)
          s_.candidates.back().feature |= static_cast<std::uint64_t>((t + 1) & 0x3fffff) << 32;
      }
    }
  }

  /// True if the triangle is the first that has the feature, and the direction stays in the feature's region.
  static bool host_feature_holds(const ContactBody& host, const SurfacePoint& point, const Vector& direction) {
    if (host.round) {
      // One triangle, two of whose corners or all are one point.
      const TriangleD core = host.triangle(point.triangle);
      return point.kind != SurfacePoint::Kind::vertex ||
             std::all_of(core.begin(), core.end(), [&](const Vector& other) {
               return (other - point.point).dot(direction) <= round_slack * (other - point.point).norm();
             });
    }
    const auto corner = static_cast<unsigned>(point.corner);
    const unsigned owned = host.surface->owned[static_cast<std::size_t>(point.triangle)];
    switch (point.kind) {
      case SurfacePoint::Kind::face:
        return !host.solid || unit_normal(host.triangle(point.triangle)).dot(direction) > 0;
      case SurfacePoint::Kind::edge: {
        if ((owned >> (3 + corner) & 1U) == 0) return false;
        const std::int32_t twin = host.features->twin_of(3 * point.triangle + point.corner);
        if (twin < 0) return true;
        const Vector n = unit_normal(host.triangle(twin / 3));
        const Vector along = host.position(twin / 3, (twin % 3 + 1) % 3) - host.position(twin / 3, twin % 3);
        if (along.cross(n).normalized().dot(direction) < -round_slack) return false;
        return !host.solid || host.normal(point).dot(direction) > 0;
      }
      case SurfacePoint::Kind::vertex: break;
    }
    if ((owned >> corner & 1U) == 0) return false;
    ContactVertex v;
    v.position = host.position(point.triangle, point.corner);
    v.side = 3 * point.triangle + point.corner;
    return in_vertex_region(host, v, direction, round_slack) && (!host.solid || host.normal(point).dot(direction) > 0);
  }

  /// Edges that have passed each other count where nothing beside them has entered less deep: vertices tell depths
  /// better, and far edges of a corner that has entered cross as well.
  void add_crossings(std::size_t first) {
    const bool both_solid = s_.a.solid && s_.b.solid;
    std::sort(s_.crossings.begin(), s_.crossings.end(),
              [](const ContactScratch::Crossing& x, const ContactScratch::Crossing& y) {
                return std::tie(y.contact.separation, x.contact.feature) <
                       std::tie(x.contact.separation, y.contact.feature);
              });
    std::size_t compared = 0;
    for (const ContactScratch::Crossing& crossing : s_.crossings) {
      compared += s_.candidates.size() - first + 1;
      if (compared > most_compared) break;
      const ContactCandidate& c = crossing.contact;
      const double reach = std::max(length_of(s_.a, crossing.edge_a), length_of(s_.b, crossing.edge_b));
      const auto tells = [&](const ContactCandidate& other) {
        const bool vertex = other.feature >> 63 == 0;
        if (other.separation > (vertex ? 0.5 * reach : 0)) return false;
        if (!vertex && other.normal.dot(c.normal) > 0.5) return false;
        const bool same_way = other.normal.dot(c.normal) > 0.5;
        if (vertex && other.separation > 0 && !same_way) return false;
        // Corners tell nothing of sharp edges that cross far from them; vertices of smooth surfaces do.
        const double far = vertex && same_way && !crossing.blunt ? std::min(reach, -4 * c.separation) : reach;
        return (other.point_a - c.point_a).norm() < far;
      };
      if (std::none_of(s_.candidates.begin() + static_cast<std::ptrdiff_t>(first), s_.candidates.end(), tells) &&
          holds(s_.b, c.point_a) && holds(s_.a, c.point_b) &&
          (both_solid || faces_meet(crossing.edge_a, crossing.edge_b))) {
        s_.candidates.push_back(c);
      }
    }
  }
  /// False for points outside a solid: edges on far sides of bodies that are apart seem to have passed each other, too.
  bool holds(const ContactBody& body, const Vector& point) const {
    SurfacePoint nearest;
    const Vector p = body.inverse(point);
    if (!body.solid || !nearest_point(*body.surface, p, std::numeric_limits<double>::infinity(), nearest)) return true;
    return nearest.distance * body.scale <= 4 * error_ ||
           feature_normal(*body.surface, *body.features, nearest).dot(p - nearest.point) <= 0;
  }
  /// True if a face at one edge touches a face at the other. Surfaces that enclose nothing have crossed only there.
  bool faces_meet(std::int32_t edge_a, std::int32_t edge_b) const {
    const std::int32_t of_a[] = {edge_a, s_.a.features->twin_of(edge_a)};
    const std::int32_t of_b[] = {edge_b, s_.b.features->twin_of(edge_b)};
    for (const std::int32_t a : of_a) {
      for (const std::int32_t b : of_b) {
        if (a < 0 || b < 0) continue;
        if (!(triangle_distance(s_.a.triangle(a / 3), s_.b.triangle(b / 3), error_).lower > 0)) return true;
      }
    }
    return false;
  }
  static double length_of(const ContactBody& body, std::int32_t side) {
    return (body.position(side / 3, (side % 3 + 1) % 3) - body.position(side / 3, side % 3)).norm();
  }

  /// Pairs that touch in a way that no rule above expects get one contact of two triangles that touch.
  void last_resort(std::size_t first) {
    for (const ContactScratch::LeafPair& pair : s_.leaf_pairs) {
      const ContactLeaf &a = s_.a.leaves[static_cast<std::size_t>(pair.a)],
                        &b = s_.b.leaves[static_cast<std::size_t>(pair.b)];
      for (int i = 0; i < a.count; ++i) {
        for (std::uint32_t left = may_touch(a, i, b, limit_ + error_); left != 0; left &= left - 1) {
          const auto j = static_cast<std::size_t>(__builtin_ctz(left));
          const std::int32_t ta = a.triangle[static_cast<std::size_t>(i)], tb = b.triangle[j];
          const TriangleD on_a = s_.a.triangle(ta), on_b = s_.b.triangle(tb);
          const TriangleDistance found = triangle_distance(on_a, on_b, error_);
          if (!(found.lower <= limit_)) continue;
          ContactCandidate c;
          c.point_a = found.point_a;
          c.point_b = found.point_b;
          const Vector apart = found.point_a - found.point_b;
          c.separation = apart.norm();
          if (c.separation > 4 * error_) {
            c.normal = apart / c.separation;
          } else {
            c.normal = (unit_normal(on_b) - unit_normal(on_a)).stableNormalized();
            if (c.normal.isZero()) c.normal = unit_normal(on_b);
            if (c.normal.isZero()) c.normal = Vector::UnitZ();
          }
          c.feature = std::uint64_t{3} << 62 | static_cast<std::uint64_t>(s_.a.first_triangle + ta) << 31 |
                      static_cast<std::uint64_t>(s_.b.first_triangle + tb);
          if (s_.candidates.size() == first) {
            s_.candidates.push_back(c);
          } else if (c.separation < s_.candidates.back().separation) {
            s_.candidates.back() = c;
          }
        }
      }
    }
  }

  /// How far apart points may be that are displaced like this towards each other, along the normal.
  double reach(const Vector& displacement, const Vector& normal) const {
    return limit_ + std::max(0.0, -displacement.dot(normal));
  }
  bool reaches(const ContactBody& guest, const ContactVertex& v, double squared) const {
    if (squared <= wide_ * wide_) return true;
    if (motion_.at_rest) return false;
    const double far = wide_ + guest.displacement(v.position).norm();
    return squared <= far * far;
  }

  ContactScratch& s_;
  const PairMotion& motion_;
  const double limit_, error_;
  const std::span<const ContactSide> sides_;
  std::vector<ContactSide>& new_sides_;
  const bool with_last_resort_;
  ContactMemory* const memory_;  ///< to be made, or null
  bool again_ = false;           ///< vertices come from a memory
  double wide_ = limit_;         ///< the limit for what is remembered
  double far_ = limit_;          ///< no contact comes of what is farther apart than this at the start
  double turn_ = 0;              ///< radians that the bodies may turn while the memory holds
  int searches_ = 0;
  Vector before_;
};

}  // namespace

void find_contacts(ContactScratch& scratch, const ContactQuery& query, ContactMemory* memory) {
  Search(scratch, query, memory).run();
}

void find_contacts_again(ContactScratch& scratch, const ContactQuery& query, const ContactMemory& memory,
                         double approach) {
  Search(scratch, query, nullptr).run_again(memory, approach);
}

}  // namespace encage
