// SPDX-License-Identifier: Apache-2.0
#pragma once

// Contacts of all bodies of a World: the search for pairs and the narrow phase in one call.

#include <encage/contact.h>
#include <encage/executor.h>
#include <encage/export.h>
#include <encage/manifold.h>
#include <encage/world.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

/// Two bodies, or a body and a half-space, that touch or are about to.
struct ContactPair {
  BodyId a = BodyId::none;
  BodyId b = BodyId::none;                     ///< has a larger index than a; none if the other one is `half_space`
  HalfSpaceId half_space = HalfSpaceId::none;  ///< none if the other one is the body `b`
  PairEvent event = PairEvent::begin;          ///< of contacts: `begin` for a pair that had none in the call before
  std::span<const ManifoldPoint> points{};     ///< as contact_manifold() gives them, from a to the other one
  std::optional<Contact> first{};              ///< as first_contact() gives it
};

struct WorldContactOptions {
  /// World units, in [0, 1e150]. Surfaces that are apart by no more than this, or may come that near during the
  /// motions, get points. Margins of shapes and bodies, bounds of deformation, and what
  /// corrections of poses move are added for each pair.
  double margin = 0;
  bool manifolds = true;        ///< false: no points
  bool first_contacts = false;  ///< true: times of first contact as well, along arcs with WorldOptions::arcs
  /// World units, in [0, 1e150], usually 0. The margin of times of first contact, to which those of the pair are added.
  double first_margin = 0;
  int most_points = 16;    ///< of a pair, in [1, 1024]
  int most_per_patch = 4;  ///< > 0
  /// As CandidateOptions::accept.
  std::function<bool(const CandidatePair&)> accept{};
  /// If set, it is called with every pair that had contacts in the call before and has none now (PairEvent::end,
  /// without points), by the ids that the pair had, in the order of pairs and between the visits.
  std::function<void(const ContactPair&)> ended{};
  /// Threads for the search and for contacts. Results and their order do not depend on it. By default only the calling
  /// thread works.
  Executor executor{};
};

struct WorldContactStatistics {
  CandidateStatistics search{};  ///< of World::find_candidates()
  std::int64_t pairs = 0;        ///< with contacts
  std::int64_t points = 0;       ///< of all pairs
};

/// Finds the contacts of the bodies of one World, and remembers for each pair what contact_manifold() knows of the step
/// before. A copy remembers the same: copy it with World::snapshot() for rollback. A step of an engine is: set motions
/// to where the velocities lead, call find(), solve, set poses. Not for use by several threads at a time.
class WorldContacts {
 public:
  WorldContacts();
  ~WorldContacts();
  WorldContacts(const WorldContacts& other);
  WorldContacts& operator=(const WorldContacts& other);
  WorldContacts(WorldContacts&&) noexcept;
  WorldContacts& operator=(WorldContacts&&) noexcept;

  /// Calls visit(const ContactPair&) for every pair that filters allow and whose surfaces are, or come, nearer than the
  /// margin; also for a pair of which a body is inside the other. Pairs come in the order of World::find_candidates(),
  /// which this calls first, with its sleep and events. The pair is valid during the call. The calling thread calls
  /// visit, accept and ended; visit and ended may change the world. If one of them throws, the next call continues with
  /// the events that have not been delivered. Allocates only while memory grows: there are more pairs than ever before,
  /// or pairs with more contacts.
  ///
  /// Throws Error for options out of range, for a candidate whose shape has no fine mesh, and if the mesh of a
  /// ShapeCache cannot be read; what it remembers is kept.
  template <class Visit>
  WorldContactStatistics find(World& world, const WorldContactOptions& options, Visit&& visit) {
    return visit_contacts(
        world, options,
        [](void* context, const ContactPair& pair) { (*static_cast<std::remove_reference_t<Visit>*>(context))(pair); },
        const_cast<void*>(static_cast<const void*>(&visit)));
  }
  /// find() with a plain function.
  WorldContactStatistics visit_contacts(World& world, const WorldContactOptions& options,
                                        void (*visit)(void* context, const ContactPair& pair), void* context);

  void clear() noexcept;  ///< forgets all pairs without events, e.g. before use with another world

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace encage
