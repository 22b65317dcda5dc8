// SPDX-License-Identifier: Apache-2.0
#pragma once

// Many bodies: which pairs have to be looked at in a step?

#include <encage/broadphase.h>
#include <encage/error.h>
#include <encage/executor.h>
#include <encage/export.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

/// Numbers that a World gives, each kind from 0 upwards; never the same one twice.
enum class ShapeId : std::uint32_t {};
enum class BodyId : std::uint32_t { none = 0xffffffff };
enum class HalfSpaceId : std::uint32_t { none = 0xffffffff };

/// A pair is looked at if each one's category has a bit in common with the other's mask.
struct Filter {
  std::uint32_t category = 1;
  std::uint32_t mask = ~std::uint32_t{0};
};

struct BodyOptions {
  Filter filter{};
  /// Two bodies of the same positive group always are a pair, two of the same
  /// negative group never; otherwise their filters decide. 0: no group.
  std::int32_t group = 0;
  /// Static bodies do not pair with each other, nor with half-spaces, and rest in every step.
  bool is_static = false;
  /// World units, finite and >= 0: added to the margin of every pair of the body.
  double margin = 0;
};

/// A pair that could not be proven separated.
struct CandidatePair {
  BodyId a = BodyId::none;
  BodyId b = BodyId::none;                     ///< a < b; none: the other is `half_space`
  HalfSpaceId half_space = HalfSpaceId::none;  ///< none: the other is `b`
  Verdict verdict{};                           ///< the last stage asked
  /// Pairs of fine triangles not proven farther apart than the margin, if asked for; empty for half-spaces.
  /// Also empty where only containment could not be excluded, or a body has no fine mesh.
  std::span<const TrianglePair> triangles{};
};

struct CandidateOptions {
  /// What is asked of a pair. To `pair.margin`, finite and >= 0, the margins of its bodies are added. The
  /// world asks boxes in any case, and once: `pair.boxes` has no effect.
  PairOptions pair{};
  /// Collect the pairs of triangles of each candidate.
  bool triangles = false;
  /// If set: called with every pair that filters allow and whose world boxes overlap, not yet with a verdict,
  /// in order, by the calling thread, before any candidate is visited; the pair is dropped if it returns false.
  std::function<bool(const CandidatePair&)> accept{};
  /// Threads for the tests of pairs and the collection of triangles. The results, their order and the statistics
  /// do not depend on it. Nothing set: the calling thread alone.
  Executor executor{};
};

/// Numbers of pairs; apart from `asked`, they depend on the bodies and options alone.
struct CandidateStatistics {
  std::int64_t overlapping = 0;             ///< allowed by filters, world boxes not proven apart
  std::int64_t refused = 0;                 ///< of these, by CandidateOptions::accept
  std::array<std::int64_t, 3> separated{};  ///< of these, proven separated, by Stage
  std::int64_t candidates = 0;              ///< of these, what is left
  std::int64_t asked = 0;                   ///< pairs tested in this search; the others had been, in an earlier one
};

/// Bodies and half-spaces, and the search for pairs that may come into contact during a step. Only pairs of
/// which a body has another motion than in the search before are tested; an unchanged pair costs some nanoseconds.
///
/// Candidates depend on shapes, motions, options and numbers alone, not on the
/// order of calls that led there. Bad input throws Error, which names the body by its number and the
/// reason, and leaves the world unchanged; so does std::bad_alloc. Lengths are in world units.
///
/// A world is used by one thread at a time: a search writes to its buffers. That search may borrow
/// threads (CandidateOptions::executor). Different worlds, also with the same shapes, are independent.
class World {
 public:
  World();
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// The world shares the shape and keeps it while it lives. Throws Error for a null shape.
  ShapeId add_shape(ShapePtr shape);

  /// A body at rest. Throws Error for an unknown shape, a pose that is not finite or
  /// farther than 1e-9 from rigid, and a margin that is negative or not finite.
  BodyId add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options = {});

  /// Throws Error if the normal is longer or shorter than 1 by more than 1e-9, or something is not finite.
  HalfSpaceId add_half_space(const HalfSpace& half_space, const Filter& filter = {});

  void remove_body(BodyId body);

  /// What the body does in the next steps, until it is set again: rest, or move. Throws Error
  /// for a motion that is not usable (is_usable()), e.g. one that turns by 180
  /// degrees or more, and for a static body that would not rest.
  void set_pose(BodyId body, const Eigen::Isometry3d& pose);
  void set_motion(BodyId body, const Motion& motion);

  // References stay valid until the next call that is not const.
  const Motion& motion(BodyId body) const;
  const BodyOptions& options(BodyId body) const;
  const ShapePtr& shape(BodyId body) const;
  const HalfSpace& half_space(HalfSpaceId half_space) const;

  bool contains(BodyId body) const noexcept;  ///< has been added and not removed
  std::int64_t shape_count() const noexcept;
  std::int64_t body_count() const noexcept;  ///< without removed ones
  std::int64_t half_space_count() const noexcept;

  /// Calls visit(const CandidatePair&) for every pair that filters allow and that neither world boxes nor
  /// separated() prove separated: by increasing a, for each a first the bodies b by increasing number, then the
  /// half-spaces. The pair and its triangles are valid during the call. visit may read the world but not change it
  /// (throws Error); accept likewise. Both are called by the calling thread while no task runs; what
  /// they or the executor throw ends the search. Allocates nothing unless there are more pairs or triangles than
  /// ever before; for triangles with an executor once 2 MiB. Throws Error for a bad margin or number of threads.
  template <class Visit>
  CandidateStatistics find_candidates(const CandidateOptions& options, Visit&& visit) {
    return visit_candidates(
        options,
        [](void* context, const CandidatePair& pair) {
          (*static_cast<std::remove_reference_t<Visit>*>(context))(pair);
        },
        const_cast<void*>(static_cast<const void*>(&visit)));
  }
  /// find_candidates() with a plain function.
  CandidateStatistics visit_candidates(const CandidateOptions& options,
                                       void (*visit)(void* context, const CandidatePair& pair), void* context);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace encage
