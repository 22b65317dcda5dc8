// SPDX-License-Identifier: Apache-2.0
#pragma once

// Continuous narrow phase: when do linearly moving triangles first touch?
// Conservative: a contact is reported wherever its absence is not proven.

#include <encage/affine_map.h>
#include <encage/export.h>
#include <encage/fine_lease.h>
#include <encage/separated.h>

#include <array>
#include <cstdint>
#include <optional>

namespace ENCAGE_EXPORT encage {

class SimpleShape;

struct ContactOptions {
  /// World units, >= 0: what is not proven farther apart than this counts as contact.
  double margin = 0;
  /// World units, >= 0: how far both bodies together leave their straight paths
  /// at mid-step, at most; enters as arc * 4 t (1 - t). Sum of arc_margin() of
  /// both bodies makes the answer hold for the true rigid arcs.
  double arc = 0;
  /// In [0, 1]: contacts that begin later are not asked for.
  double latest = 1;
};

/// Four points that move linearly during a step.
struct MovingPoints {
  std::array<Eigen::Vector3d, 4> start;
  std::array<Eigen::Vector3d, 4> end;
};

/// First contact of the vertex points[0] and the face points[1], [2], [3]: a lower bound of its time in
/// [0, 1], a multiple of 2^-22, or no value if proven that there is none up to
/// options.latest. No contact is missed. One is reported although there is none, or earlier than 2^-21
/// before it, only where the features come closer than the margin plus rounding (2^-46 of the largest
/// difference of their coordinates, of margin and arc), with a margin now and then plus their motion in
/// 2^-22 of the step. Contact at time 0 if a number is not finite, or negative where it must not be; so for
/// features smaller than 1e-40 or farther than 1e40. Never throws, never allocates.
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
  double time = 0;  ///< in [0, 1]: not later than the first contact
  ContactKind kind = ContactKind::vertex_face;
  /// Vertices of the fine meshes, those of a's feature first, each feature's in increasing order; -1: unused.
  std::array<std::int32_t, 4> vertices = {-1, -1, -1, -1};
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< world, midway between the features at `time`
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< world, unit length, from b towards a
};

/// Narrow phase of one pair of bodies, fed with pairs of triangles by whatever
/// broad phase found them. The result is the least contact by (time, kind,
/// vertices): it does not depend on the order of the pairs, nor on how many
/// pairs without contact are among them. Each pair of features is tested once,
/// with the triangles that own them (Curtis et al. 2008, "Fast collision
/// detection for deformable models using representative triangles"): every
/// pair of triangles in contact has to be handed in.
///
/// Both shapes, of compounds all parts, need a fine mesh and must outlive this. It keeps the meshes in memory that it
/// works on; constructor and test() throw Error if one of a ShapeCache cannot be read, and nothing else. A step's
/// rotation must stay below 180 degrees (asserted, as are usable poses). Not for use by several threads; never
/// allocates.
class PairContact {
 public:
  PairContact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
              const ContactOptions& options = {});

  /// Triangles of the fine meshes, as CageHierarchy::fine counts them.
  void test(std::int32_t triangle_a, std::int32_t triangle_b);

  const std::optional<Contact>& first() const noexcept { return first_; }
  /// Contacts that begin later cannot change the result.
  double latest() const noexcept { return first_ ? first_->time : options_.latest; }

  /// Pairs of features asked so far.
  std::int64_t feature_tests() const noexcept { return feature_tests_; }

 private:
  void consider(ContactKind kind, const MovingPoints& points, const std::array<std::int32_t, 4>& vertices) noexcept;

  // A simple shape, or the part of a compound that was asked last.
  struct Side {
    Side(const Shape& shape, const Motion& of_whole) : whole(shape), whole_motion(of_whole) {}
    bool turn_to(std::int32_t triangle);  // false: there already

    const Shape& whole;
    Motion whole_motion;
    FineLease lease;
    const SimpleShape* part = nullptr;
    Motion motion{};
    double slack = 0;
    std::int32_t first_triangle = 0, first_vertex = 0, triangle_count = 0;
    std::array<AffineMap, 2> ends{};  // local frame to the frame of the computation, start and end
  };

  Side a_, b_;
  ContactOptions options_;
  bool placed_ = false;  // ends and required_ are those of the two parts
  double required_ = 0;  // distance that proves absence of contact, rounding included
  std::optional<Contact> first_;
  std::int64_t feature_tests_ = 0;
};

/// First contact of the surfaces of two moving bodies: boxes, body-frame trees,
/// then PairContact, with the same result as PairContact over all pairs of
/// triangles. No value: proven that meshes that do not
/// intersect at the start do not touch during the step (docs/guarantee.md); whether they do, separated() at rest tells.
/// Says nothing of one body wholly inside the other. Requirements and Error as PairContact: of shapes of a ShapeCache
/// the fine meshes are needed in any case, so ask separated() first. Re-entrant; otherwise never throws nor allocates.
std::optional<Contact> first_contact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                                     const ContactOptions& options = {});

/// First contact of a moving body and a half-space; options.latest and Error as above.
std::optional<Contact> first_contact(const Shape& a, const Motion& motion_a, const HalfSpace& plane,
                                     const ContactOptions& options = {});

}  // namespace encage
