// SPDX-License-Identifier: Apache-2.0
#pragma once

// Continuous narrow phase: it computes when linearly moving triangles first touch. It is conservative: it reports a
// contact wherever it cannot prove that there is none.

#include <encage/affine_map.h>
#include <encage/export.h>
#include <encage/fine_lease.h>
#include <encage/separated.h>

#include <array>
#include <cstdint>
#include <optional>

namespace ENCAGE_EXPORT encage {

class FirstContactSearch;
class SimpleShape;

struct ContactOptions {
  /// World units, >= 0, usually 0. Bodies that are not proven farther apart than this count as touching.
  double margin = 0;
  /// World units, >= 0, usually 0. Bounds how far both bodies together leave their straight paths at mid-step; at time
  /// t in [0, 1] the bound is arc * 4 t (1 - t). With the sum of both bodies' arc_margin() the result holds for the
  /// true rigid arcs.
  double arc = 0;
  /// In [0, 1], usually 1. The query does not look for contacts that begin later.
  double latest = 1;
  /// >= 0. Budget of work of first_contact(): a step is about the test of a box against eight, some 50 to 100 ns. The
  /// number of steps that a query takes depends on its arguments alone.
  std::int64_t most_steps = 1 << 20;
};

/// Four points that move linearly during a step.
struct MovingPoints {
  std::array<Eigen::Vector3d, 4> start;
  std::array<Eigen::Vector3d, 4> end;
};

/// Returns a lower bound of the time of first contact between the vertex points[0] and the face points[1], [2], [3]: a
/// multiple of 2^-22 in [0, 1], or no value if it is proven that there is no contact up to options.latest. No contact
/// is missed. A contact is reported although there is none, or earlier than 2^-21 before it, only where the features
/// come closer than the margin plus rounding (2^-46 of the largest difference of their coordinates, of margin and arc);
/// with a margin, occasionally also where they come closer than that plus their motion in 2^-22 of the step. The time
/// is 0 if a number is not finite, or is negative where it must not be; it may be 0 for features smaller than 1e-40 or
/// farther apart than 1e40. Never throws, never allocates. Re-entrant.
std::optional<double> vertex_face_time(const MovingPoints& points, const ContactOptions& options = {}) noexcept;

/// The same for the edges points[0] points[1] and points[2] points[3].
std::optional<double> edge_edge_time(const MovingPoints& points, const ContactOptions& options = {}) noexcept;

enum class ContactKind : std::uint8_t {
  vertex_face,  ///< a vertex of a, a face of b
  face_vertex,  ///< a face of a, a vertex of b
  edge_edge,
  vertex_plane,  ///< a vertex of a, a half-space
};

/// First contact of two bodies, or of a body and a half-space.
struct Contact {
  /// In [0, 1]: no contact begins earlier. The features below touch within 2^-20 of it, unless the bodies overlap.
  double time = 0;
  ContactKind kind = ContactKind::vertex_face;
  /// Vertices of the fine meshes: first those of a's feature, then those of b's, each in increasing order. Unused
  /// entries are -1.
  std::array<std::int32_t, 4> vertices = {-1, -1, -1, -1};
  /// World, midway between the features at `time`; where primitives have a convex radius, between their surfaces.
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// World, unit length, from b towards a: the bodies part if a moves along it. Of overlapping bodies it is that of
  /// some features that touch, and need not part them.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  /// The surfaces are proven to cross at the start, cores of primitives to be nearer than their radii, or a vertex to
  /// be inside the half-space; `time` is 0 then. Bodies that merely touch, and one that lies inside the other, do not
  /// count.
  bool overlapping = false;
  /// first_contact() reached the end of its budget of work (ContactOptions::most_steps), as happens where very many
  /// triangles touch at once or stay very near each other. No contact begins before `time`. But the features may touch
  /// later than that or just come near each other, others may suit the ranking of PairContact better, and that surfaces
  /// cross may have been overlooked.
  bool exhausted = false;
};

/// Narrow phase of one pair of bodies. Any broad phase may supply the pairs of triangles. The time is that of the
/// earliest contact. Where several features touch within 2^-20 of the step from then on, the contact is that of the
/// features whose triangles lie on both sides of the plane of contact, that are nearest if there is a margin, that
/// approach most directly, and whose triangles face each other; equals are ordered by time, kind and vertices. So it
/// does not depend on the order of the pairs, nor on how many pairs without contact are among them. Each pair of
/// features is tested once, with the triangles that own them (Curtis et al. 2008, "Fast collision detection for
/// deformable models using representative triangles"). Therefore every pair of triangles in contact has to be passed to
/// test().
///
/// Both shapes, and all parts of compounds, need a fine mesh and must outlive this object. The object keeps the meshes
/// that it works on in memory. The constructor throws Error, which names the body and the reason, for a motion that is
/// not usable (is_usable()): a pose in float or one that mirrors, a rotation of 180 degrees, a scale that is not
/// positive. It and test() throw Error if a mesh of a ShapeCache cannot be read, and nothing else. Not for use by
/// several threads at a time; never allocates, except that a ShapeCache may have to read a fine mesh.
class PairContact {
 public:
  PairContact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
              const ContactOptions& options = {});

  /// Tests two triangles of the fine meshes, numbered as in CageHierarchy::fine.
  void test(std::int32_t triangle_a, std::int32_t triangle_b);

  const std::optional<Contact>& first() const noexcept { return first_; }
  /// Contacts that begin later than this time, in [0, 1], cannot change the result.
  double latest() const noexcept { return latest_; }

  /// Number of pairs of features tested so far.
  std::int64_t feature_tests() const noexcept { return feature_tests_; }

 private:
  static constexpr double tick = 0x1p-22;  // times are multiples of it
  struct Side;
  struct Placed;
  void turn_to(std::int32_t triangle_a, std::int32_t triangle_b);
  static Placed placed(const Side& side, std::int32_t triangle);
  template <class Visit>
  static void for_each_feature_pair(const Placed& a, const Placed& b, Visit&& visit);
  struct Triangles;
  void consider(ContactKind kind, const MovingPoints& points, const std::array<std::int32_t, 4>& vertices,
                const Triangles& triangles) noexcept;
  void note_crossing(const Triangles& triangles, const std::array<std::int32_t, 3>& vertices_a,
                     const std::array<std::int32_t, 3>& vertices_b) noexcept;
  struct Found;
  void add(const Found& found) noexcept;

  // For first_contact().
  friend class FirstContactSearch;
  void ignore_ties() noexcept;
  void suppose(std::int32_t triangle_a, std::int32_t triangle_b, double time);

  // A simple shape, or the part of a compound that was tested last.
  struct Side {
    Side(const Shape& shape, const Motion& motion_of_body) : body(shape), body_motion(motion_of_body) {}
    bool turn_to(std::int32_t triangle);  // returns false if this part is current already

    const Shape& body;
    Motion body_motion;
    FineLease lease;
    const SimpleShape* part = nullptr;
    Motion motion{};
    double slack = 0;
    std::int32_t first_triangle = 0, first_vertex = 0, triangle_count = 0;
    std::array<AffineMap, 2> ends{};  // local frame to the frame of the computation, start and end
  };

  Side a_, b_;
  ContactOptions options_;
  bool placed_ = false;  // true if ends and required_ are those of the two current parts
  double required_ = 0;  // a larger distance proves absence of contact, rounding included
  double rounding_ = 0;  // that of required_ without margins

  // How well a contact parts the bodies, best first.
  struct Rank {
    double distance = 0;
    bool unsupported = false;
    double receding = 0;  // the share of the path along the normal
    double averted = 0;   // how far the triangles face away from each other
  };
  struct Ranked {
    Contact contact;
    Rank rank;
  };
  static constexpr int window = 4;
  std::array<std::optional<Ranked>, window + 1> best_;  // of each multiple of 2^-22, from the earliest contact on
  double latest_;
  bool overlapping_ = false, exhausted_ = false;
  bool ignores_ties_ = false;  // true if only contacts before the first one found are of interest
  std::optional<Contact> first_;
  std::int64_t feature_tests_ = 0, contacts_ = 0;
  std::int64_t steps_ = 0;  // as in ContactOptions
};

/// Finds the first contact of the surfaces of two moving bodies: it tests boxes, then the bodies' trees, and passes the
/// remaining triangles to PairContact. The result is that of PairContact over all pairs of triangles. No value means:
/// it is proven that meshes that do not intersect at the start do not touch during the step (docs/guarantee.md).
/// separated() at rest can prove that they do not intersect at the start. Of primitives the result holds for the body,
/// not for the mesh: features touch where they are as far apart as the convex radii and fine_error() of primitives say
/// (that of meshes does not count); the contact's vertices are those of cores. The result says nothing about a body
/// that lies inside the other without touching it. Bodies turn the short way, whatever the rotation was (Motion), and
/// their vertices move straight but for ContactOptions::arc. Requirements and errors are those of PairContact. The
/// query always needs the fine meshes, so for shapes of a ShapeCache call separated() first. Where the budget of work
/// ends the query, the contact says so: Contact::exhausted. Re-entrant; otherwise never throws, and allocates only
/// where a ShapeCache has to read a mesh.
std::optional<Contact> first_contact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                                     const ContactOptions& options = {});

/// Finds the first contact of a moving body and a half-space. options.latest and errors are as above; the half-space is
/// as HalfSpace says.
std::optional<Contact> first_contact(const Shape& a, const Motion& motion_a, const HalfSpace& plane,
                                     const ContactOptions& options = {});

}  // namespace encage
