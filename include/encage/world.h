// SPDX-License-Identifier: Apache-2.0
#pragma once

// Many bodies: which pairs have to be looked at in a step?

#include <encage/error.h>
#include <encage/executor.h>
#include <encage/export.h>
#include <encage/separated.h>

#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

/// Ids that a World gives, each kind its own: the index in the low 32 bits, from 0 upwards, and the generation in the
/// high 32 bits. The index of what was removed is given again, the last one freed first, with
/// another generation: an id means one thing only.
enum class ShapeId : std::uint64_t {};
enum class BodyId : std::uint64_t { none = ~std::uint64_t{0} };
enum class HalfSpaceId : std::uint64_t { none = ~std::uint64_t{0} };

template <class Id>
concept WorldId = std::same_as<Id, ShapeId> || std::same_as<Id, BodyId> || std::same_as<Id, HalfSpaceId>;

/// For arrays of the caller's: no larger than the largest number of such things at any one time, less 1.
template <WorldId Id>
constexpr std::uint32_t index(Id id) noexcept {
  return static_cast<std::uint32_t>(id);
}

/// How often the index has been given before.
template <WorldId Id>
constexpr std::uint32_t generation(Id id) noexcept {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(id) >> 32);
}

/// A pair is looked at if each one's category has a bit in common with the other's mask.
struct Filter {
  std::uint32_t category = 1;
  std::uint32_t mask = ~std::uint32_t{0};
  friend bool operator==(const Filter&, const Filter&) = default;
};

/// Of the bodies of a pair at least one is dynamic; only dynamic bodies pair with half-spaces.
enum class BodyKind : std::uint8_t {
  dynamic,    ///< moved by forces and contacts
  kinematic,  ///< moved by the caller, whatever is in the way
  static_,    ///< rests in every step, and is never awake
};

struct BodyOptions {
  Filter filter{};
  /// Two bodies of the same positive group always are a pair, two of the same
  /// negative group never; otherwise their filters decide. 0: no group.
  std::int32_t group = 0;
  BodyKind kind = BodyKind::dynamic;
  /// World units, in [0, 1e150]: added to the margin of every pair of the body.
  double margin = 0;
  double scale = 1;  ///< in [1e-50, 1e50]: that of all its motions
  friend bool operator==(const BodyOptions&, const BodyOptions&) = default;
};

/// What has become of a pair since the search before.
enum class PairEvent : std::uint8_t {
  begin,    ///< was no candidate and is one
  persist,  ///< was one and still is
  end,      ///< was one and no longer is: proven separated, not accepted, not allowed, or one of both removed
};

/// A pair that could not be proven separated.
struct CandidatePair {
  BodyId a = BodyId::none;
  BodyId b = BodyId::none;                     ///< of larger index than a; none: the other is `half_space`
  HalfSpaceId half_space = HalfSpaceId::none;  ///< none: the other is `b`
  PairEvent event = PairEvent::begin;
  Verdict verdict{};  ///< the last stage asked
  /// Pairs of fine triangles not proven farther apart than the margin, if asked for; empty for half-spaces.
  /// Also empty where only containment could not be excluded, or a body has no fine mesh.
  std::span<const TrianglePair> triangles{};
};

struct CandidateOptions {
  /// What is asked of a pair. To `pair.margin`, in [0, 1e150], the margins of its bodies are added. The
  /// world asks boxes in any case, and once: `pair.boxes` has no effect.
  PairOptions pair{};
  /// Collect the pairs of triangles of each candidate.
  bool triangles = false;
  /// If set: called with every pair that filters allow and whose world boxes overlap, not yet with a verdict,
  /// in order, by the calling thread, before any candidate is visited; the pair is dropped if it returns false.
  /// Its event is that which it has if it becomes a candidate.
  std::function<bool(const CandidatePair&)> accept{};
  /// If set: called with every pair that was a candidate and no longer is (PairEvent::end, without triangles), by the
  /// ids that it had, in the order of the candidates and between their visits: where indices are the same, an ended
  /// pair comes first.
  std::function<void(const CandidatePair&)> ended{};
  /// Threads for the tests of pairs and the collection of triangles. The results, their order and the statistics
  /// do not depend on it. Nothing set: the calling thread alone.
  Executor executor{};
};

/// Numbers of pairs; apart from the last two, they depend on the bodies and options alone.
struct CandidateStatistics {
  std::int64_t overlapping = 0;             ///< allowed by filters, not asleep, world boxes not proven apart
  std::int64_t refused = 0;                 ///< of these, by CandidateOptions::accept
  std::array<std::int64_t, 3> separated{};  ///< of these, proven separated, by Stage
  std::int64_t candidates = 0;              ///< of these, what is left
  std::int64_t asked = 0;                   ///< pairs tested in this search; the others had been, in an earlier one
  /// Pairs that the search went through: allowed, not asleep, boxes that overlap, or do at the largest margin so far.
  std::int64_t listed = 0;
};

class WorldSnapshot;

/// Bodies and half-spaces, and the search for pairs that may come into contact during a step. Only pairs of
/// which a body has another motion than in the search before are tested; an unchanged pair costs some nanoseconds.
///
/// *Sleep.* Bodies are awake until the caller puts them to sleep; the world itself wakes none. A pair of two
/// bodies that are asleep or static (or of one and a half-space) is left out, once it has been searched after the last
/// change of either, and costs nothing. So nothing is missed: it is as it was. A kinematic body is awake, too, until
/// it is put to sleep, and its pairs with sleeping bodies are searched. A pair that is left out has no events; when a
/// body wakes or is changed, the pair persists or ends. A search with a larger margin than that at which pairs were
/// left out looks at all of them once.
///
/// Candidates depend on shapes, motions, options and ids alone, not on the
/// order of calls that led there; events on the candidates of the search before, whatever its options. Bad input throws
/// Error, which names the body, the value and the reason, and leaves the world unchanged; so does std::bad_alloc.
/// Lengths are in world units.
///
/// A world is used by one thread at a time: a search writes to its buffers. That search may borrow
/// threads (CandidateOptions::executor). Different worlds, also with the same shapes, are independent.
class World {
 public:
  World();
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// The world shares the shape and keeps it until it is removed. The margin, in [0, 1e150], is added to that of every
  /// pair of its bodies. Throws Error for a null shape or a bad margin.
  ShapeId add_shape(ShapePtr shape, double margin = 0);

  /// A body at rest, awake unless it is static. Throws Error for an unknown shape, a pose that is not finite, mirrors, or
  /// is farther than 1e-9 from rigid, and for bad options.
  BodyId add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options = {});

  /// Throws Error if the normal is longer or shorter than 1 by more than 1e-9, or something is not finite.
  HalfSpaceId add_half_space(const HalfSpace& half_space, const Filter& filter = {});

  void remove_shape(ShapeId shape);  ///< throws Error while a body has it
  void remove_body(BodyId body);
  void remove_half_space(HalfSpaceId half_space);

  /// Rest or motion of the body in the next steps, until it is set again. The body turns the short way from the start to
  /// the end pose: two poses do not tell 190 degrees from -170. Throws Error for a motion that is not usable
  /// (is_usable()), e.g. one whose poses are 180 degrees apart, for a static body that would not rest, and for a
  /// motion.scale that is neither 1 nor the body's; the body keeps its own scale in either case.
  void set_pose(BodyId body, const Eigen::Isometry3d& pose);
  void set_motion(BodyId body, const Motion& motion);

  void set_shape(BodyId body, ShapeId shape);
  /// All options at once. A body that becomes static falls asleep, one that ceases to be wakes. Throws Error for bad
  /// options, and for a body that would become static while it moves.
  void set_options(BodyId body, const BodyOptions& options);
  void set_filter(BodyId body, const Filter& filter);
  void set_scale(BodyId body, double scale);

  /// No effect on static bodies.
  void set_awake(BodyId body, bool awake);

  /// How far, in [0, 1e150], surface points may be from where the motion takes them, in the next steps and until it is
  /// set again: each vertex by any vector up to this length, its triangles with it, vertices at the same place alike.
  /// Added to the margin of every pair of the body, so that what is proven holds for the deformed body; 0 at first.
  void set_deformation(BodyId body, double bound);

  // References stay valid until the next call that is not const.
  const Motion& motion(BodyId body) const;
  const BodyOptions& options(BodyId body) const;
  const ShapePtr& shape(BodyId body) const;
  ShapeId shape_id(BodyId body) const;
  bool is_awake(BodyId body) const;
  double deformation(BodyId body) const;
  const ShapePtr& shape(ShapeId shape) const;
  double margin(ShapeId shape) const;
  const HalfSpace& half_space(HalfSpaceId half_space) const;

  // Has been added and not removed.
  bool contains(ShapeId shape) const noexcept;
  bool contains(BodyId body) const noexcept;
  bool contains(HalfSpaceId half_space) const noexcept;
  // Without removed ones.
  std::int64_t shape_count() const noexcept;
  std::int64_t body_count() const noexcept;
  std::int64_t half_space_count() const noexcept;

  /// Calls visit(const CandidatePair&) for every pair that filters allow, that is not left out for sleep, and that
  /// neither world boxes nor separated() prove separated: by increasing index of a, for each a first the bodies b by
  /// increasing index, then the half-spaces. The pair and its triangles are valid during the call. visit may read the
  /// world but not change it (throws Error); accept and ended likewise. All are called by the calling thread while no
  /// task runs; what they or the executor throw ends the search, and the next one goes on with the events that had not
  /// come yet. Allocates nothing unless there are more pairs or triangles, sleeping or ended pairs than
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

  /// All there is to the world, for rollback: some 600 bytes a body and 24 a pair; shapes are shared. After restore()
  /// the same calls give the same ids, candidates, events and statistics as after the snapshot was taken.
  WorldSnapshot snapshot() const;
  /// Allocates nothing if `reused` has held as much before.
  void snapshot(WorldSnapshot& reused) const;
  /// Takes a snapshot of this or of another world. Allocates nothing if this world has held as much before. Throws
  /// Error for a snapshot that holds nothing.
  void restore(const WorldSnapshot& snapshot);

 private:
  friend class WorldSnapshot;
  class State;
  std::unique_ptr<State> state_;
};

/// What World::snapshot() gives. Immutable but for being reused: any number of threads may restore from it.
class WorldSnapshot {
 public:
  WorldSnapshot();  ///< holds nothing
  ~WorldSnapshot();
  WorldSnapshot(WorldSnapshot&&) noexcept;
  WorldSnapshot& operator=(WorldSnapshot&&) noexcept;

 private:
  friend class World;
  std::unique_ptr<World::State> state_;
};

}  // namespace encage
