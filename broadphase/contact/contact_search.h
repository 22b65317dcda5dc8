// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/contact/contact_leaf.h"
#include "broadphase/contact/index_map.h"
#include "broadphase/contact/nearest_point.h"
#include "broadphase/motion/pair_motion.h"
#include "broadphase/shape/compound.h"

#include <vector>

namespace encage {

/// A possible contact, in the common frame of a pair of parts.
struct ContactCandidate {
  Eigen::Vector3d point_a, point_b, normal;
  double separation;
  std::uint64_t feature;
};

/// The side of a body on which a vertex of the other one entered it.
struct ContactSide {
  std::uint64_t feature;
  Eigen::Vector3f normal;  ///< of the body that was entered, outward, in its local frame
};

/// An edge that can meet another one, in the common frame; see ContactEdges.
struct ContactEdge {
  Eigen::Vector3d start, along;
  std::array<Eigen::Vector3d, 2> out;
  double length;
  std::int32_t side;  ///< 3 t + k
};

/// What a search found near enough to matter soon. As long as the bodies have moved little since, only these features
/// have to be looked at again.
struct ContactMemory {
  struct Vertex {
    std::int32_t side;             ///< 3 t + k
    std::int32_t nearest, facing;  ///< triangles of the other body; -1 if there is none
  };
  struct Edges {
    std::int32_t a, b;
  };
  std::vector<Vertex> vertices_a, vertices_b;
  std::vector<Edges> edges;
  const Surface *surface_a = nullptr, *surface_b = nullptr;
  double scale_a = 1, scale_b = 1;
  double limit = 0;    ///< of the search, beyond which it remembers what is within reach
  double reach = -1;   ///< how far the bodies may have approached each other since; negative if nothing is known
  AffineMap relative;  ///< from b's local frame to a's, at the time of the search

  void clear() {
    reach = -1;
    surface_a = surface_b = nullptr;
    vertices_a.clear();
    vertices_b.clear();
    edges.clear();
  }
};

/// One body of a pair while contacts are searched. It keeps its memory from query to query.
struct ContactBody {
  const Surface* surface = nullptr;
  const SurfaceFeatures* features = nullptr;
  AffineMap map, inverse;  ///< from the local frame to the common one, scale included, and back
  AffineMap step;          ///< positions at the start to those at the end, seen from the other body
  double scale = 1;
  Eigen::Matrix3d rotation;  ///< map without the scale
  bool solid = true;         ///< otherwise the body is its surface alone, and contacts are two-sided
  bool round = false;        ///< of degenerate triangles only: the core of a sphere or a capsule
  std::int32_t first_vertex = 0, first_triangle = 0, part = 0;

  IndexMap leaf_index, vertex_index;
  std::vector<ContactLeaf> leaves;
  std::vector<ContactVertex> vertices;
  std::vector<ContactEdges> edges;

  void place(const MovingPart& moving, const AffineMap& to_common, std::int32_t number);
  /// Returns how far a point of the body, in the common frame, moves during the step, seen from the other body.
  Eigen::Vector3d displacement(const Eigen::Vector3d& p) const { return step(p) - p; }

  /// Returns the index in `leaves` of a leaf of the tree.
  std::int32_t leaf(std::int32_t first, std::int32_t count);
  /// Describes side k of a triangle; false if no other edge can meet it.
  bool edge(std::int32_t triangle, int k, const TriangleD& corners, const Eigen::Vector3d& normal,
            ContactEdge& edge) const;
  /// Returns the index in `vertices` of a corner of a triangle.
  std::int32_t vertex(std::int32_t triangle, int corner);

  std::int32_t vertex_number(std::int32_t triangle, int corner) const {
    return static_cast<std::int32_t>(
        surface->mesh.triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(corner)]);
  }
  Eigen::Vector3d located(std::int32_t vertex) const {
    return map.linear.lazyProduct(surface->vertex(vertex)) + map.offset;
  }
  Eigen::Vector3d position(std::int32_t triangle, int corner) const { return located(vertex_number(triangle, corner)); }
  TriangleD triangle(std::int32_t t) const { return {position(t, 0), position(t, 1), position(t, 2)}; }
  /// Turns a direction of the local frame.
  Eigen::Vector3d direction(const Eigen::Vector3d& local) const { return rotation.lazyProduct(local); }
  Eigen::Vector3d local_direction(const Eigen::Vector3d& common) const {
    return rotation.transpose().lazyProduct(common);
  }
  /// Unit normal of a triangle, rounded to float; 0 if it is degenerate.
  Eigen::Vector3d face_normal(std::int32_t t) const {
    return direction(features->face_normal[static_cast<std::size_t>(t)].cast<double>());
  }
  Eigen::Vector3d normal(const SurfacePoint& point) const {
    return direction(feature_normal(*surface, *features, point));
  }

 private:
  std::int32_t add_vertex(std::int32_t triangle, int corner);
  void add_edges(std::int32_t triangle, const TriangleD& corners, const Eigen::Vector3d& normal, unsigned owned,
                 ContactLeaf& leaf);
};

/// Working memory of contact_manifold(), of one thread.
struct ContactScratch {
  ContactBody a, b;
  struct LeafPair {
    std::int32_t a, b;
  };
  std::vector<LeafPair> leaf_pairs;
  std::vector<ContactCandidate> candidates;  ///< result
  struct Crossing {
    ContactCandidate contact;
    std::int32_t edge_a, edge_b;
    bool blunt;  ///< both edges are parts of smooth surfaces
  };
  std::vector<Crossing> crossings;  ///< edges that have passed each other
  enum class Where : std::uint8_t { unknown, outside, inside };
  struct Located {
    Where where = Where::unknown;
    std::int32_t patch = -1;
    SurfacePoint nearest;       ///< in the host's local frame; of vertices that are located
    std::int32_t way_out = -1;  ///< the triangle through which a vertex inside leaves
  };
  std::vector<Located> located;
  std::vector<std::int32_t> queue;
  struct Patch {
    Eigen::Vector3d area = Eigen::Vector3d::Zero();    ///< sum of the vectors of its vertices' areas
    double size = 0;                                   ///< sum of their lengths
    Eigen::Vector3d before = Eigen::Vector3d::Zero();  ///< sum of the sides of the query before
    int remembered = 0;                                ///< their number
  };
  std::vector<Patch> patches;
};

/// What a search for contacts needs besides the bodies.
struct ContactQuery {
  const PairMotion& motion;
  double limit = 0;                     ///< separation up to which contacts count at any speed
  double error = 0;                     ///< by which positions may be off
  std::span<const ContactSide> sides;   ///< of the query before, sorted by feature
  std::vector<ContactSide>& new_sides;  ///< those of this one are appended, in no order
};

/// Adds to scratch.candidates for the parts placed in scratch.a and scratch.b: points that are apart by no more than
/// the limit, or approach by more than the rest during the step. Points lie on the meshes. If `memory` is not null,
/// remembers everything within memory->reach of that, too.
void find_contacts(ContactScratch& scratch, const ContactQuery& query, ContactMemory* memory);

/// The same for bodies that have approached each other by less than memory.reach, this step included, since the memory
/// was made.
void find_contacts_again(ContactScratch& scratch, const ContactQuery& query, const ContactMemory& memory);

}  // namespace encage
