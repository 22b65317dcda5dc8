// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/contact/contact_body.h"
#include "broadphase/motion/pair_motion.h"

#include <span>
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

/// What a search found near enough to matter soon. As long as the bodies have moved little since, only these features
/// have to be looked at again.
struct ContactMemory {
  struct Vertex {
    std::int32_t side;             ///< 3 t + k
    std::int32_t nearest, facing;  ///< triangles of the other body; -1 if there is none
    double distance;               ///< to the other body; 0 inside it
  };
  struct Edges {
    std::int32_t a, b;
    double distance;
  };
  std::vector<Vertex> vertices_a, vertices_b;
  std::vector<Edges> edges;
  std::uint64_t shape_a = 0, shape_b = 0;  ///< numbers of the shapes; another shape may come to have the same address
  double scale_a = 1, scale_b = 1;
  double limit = 0;    ///< of the search, beyond which it remembers what is within reach
  double reach = -1;   ///< how far the bodies may have approached each other since; negative if nothing is known
  AffineMap relative;  ///< from b's local frame to a's, at the time of the search

  void clear() {
    reach = -1;
    shape_a = shape_b = 0;
    vertices_a.clear();
    vertices_b.clear();
    edges.clear();
  }
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
  double approach = 0;                  ///< bounds how far surfaces approach each other during the step
  std::span<const ContactSide> sides;   ///< of the query before, sorted by feature
  std::vector<ContactSide>& new_sides;  ///< those of this one are appended, in no order
  /// If true, parts that touch in a way that no rule expects get a contact nevertheless.
  bool with_last_resort = true;
};

/// Adds to scratch.candidates for the parts placed in scratch.a and scratch.b: points that are apart by no more than
/// the limit, or approach by more than the rest during the step. Points lie on the meshes. If `memory` is not null,
/// remembers everything within memory->reach of that, too.
void find_contacts(ContactScratch& scratch, const ContactQuery& query, ContactMemory* memory);

/// The same for bodies that have approached each other by at most `approach` <= memory.reach, this step included, since
/// the memory was made.
void find_contacts_again(ContactScratch& scratch, const ContactQuery& query, const ContactMemory& memory,
                         double approach);

}  // namespace encage
