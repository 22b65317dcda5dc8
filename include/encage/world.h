// SPDX-License-Identifier: Apache-2.0
#pragma once

// Search for the pairs, among many bodies, that may touch during a step.

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
#include <vector>

namespace ENCAGE_EXPORT encage {

/// Ids that a World assigns, of a separate type for each kind of object: the index in the low 32 bits, from 0 upwards,
/// and the generation in the high 32 bits. A new object takes the index that was freed last, with another generation,
/// so that no two objects ever have the same id.
enum class ShapeId : std::uint64_t {};
enum class BodyId : std::uint64_t { none = ~std::uint64_t{0} };
enum class HalfSpaceId : std::uint64_t { none = ~std::uint64_t{0} };

template <class Id>
concept WorldId = std::same_as<Id, ShapeId> || std::same_as<Id, BodyId> || std::same_as<Id, HalfSpaceId>;

/// An index for the caller's arrays. It is smaller than the largest number of such objects that existed at any one
/// time.
template <WorldId Id>
constexpr std::uint32_t index(Id id) noexcept {
  return static_cast<std::uint32_t>(id);
}

/// The number of earlier objects that had the same index.
template <WorldId Id>
constexpr std::uint32_t generation(Id id) noexcept {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(id) >> 32);
}

/// A pair is tested if the category of each has a bit in common with the mask of the other.
struct Filter {
  std::uint32_t category = 1;
  std::uint32_t mask = ~std::uint32_t{0};
  friend bool operator==(const Filter&, const Filter&) = default;
};

/// At least one body of a pair is dynamic, and only dynamic bodies pair with half-spaces, unless BodyOptions::sensor
/// asks for more.
enum class BodyKind : std::uint8_t {
  dynamic,    ///< moved by forces and contacts
  kinematic,  ///< moved by the caller, whatever is in the way
  static_,    ///< rests in every step, and is never awake
};

struct BodyOptions {
  Filter filter{};
  /// Two bodies of the same positive group are always a pair, two of the same negative group never; otherwise their
  /// filters decide. 0, the usual value, means no group.
  std::int32_t group = 0;
  BodyKind kind = BodyKind::dynamic;
  /// World units, in [0, 1e150], usually 0. It is added to the margin of every pair of the body.
  double margin = 0;
  double scale = 1;  ///< in [1e-50, 1e50], usually 1; the scale of all motions of the body
  /// True if the body also forms pairs with kinematic and static bodies and with half-spaces, whatever its own kind.
  /// Two static bodies, or a static body and a half-space, never form a pair. Usually false.
  bool sensor = false;
  /// Body frame, before scaling, each coordinate in [-1e150, 1e150]: the point that stays on its straight path while
  /// the body turns, usually the centre of mass. It counts only with WorldOptions::arcs.
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
  friend bool operator==(const BodyOptions&, const BodyOptions&) = default;
};

/// The change of a pair since the previous search.
enum class PairEvent : std::uint8_t {
  begin,    ///< was no candidate and is one now
  persist,  ///< was a candidate and still is
  end,      ///< was a candidate and no longer is: proven separated, refused, not allowed, or a member was removed
};

/// A pair that could not be proven separated.
struct CandidatePair {
  BodyId a = BodyId::none;
  BodyId b = BodyId::none;                     ///< has a larger index than a; none if the other one is `half_space`
  HalfSpaceId half_space = HalfSpaceId::none;  ///< none if the other one is the body `b`
  PairEvent event = PairEvent::begin;
  Verdict verdict{};  ///< of the last stage tested
  /// The pairs of fine triangles that are not proven farther apart than the margin, if CandidateOptions::triangles is
  /// set. Empty for half-spaces, for pairs of which only containment could not be excluded, and if a body has no fine
  /// mesh.
  std::span<const TrianglePair> triangles{};
};

struct CandidateOptions {
  /// Stages and margin of each pair. The margins of both bodies are added to `pair.margin`, in [0, 1e150]. The world
  /// tests boxes in any case, and once: `pair.boxes` has no effect.
  PairOptions pair{};
  /// True if the search collects the pairs of triangles of each candidate. Usually false.
  bool triangles = false;
  /// If set, the calling thread calls it, in order and before any candidate is visited, with every pair that filters
  /// allow and whose world boxes overlap. The pair has no verdict yet; its event is the one that it has if it becomes a
  /// candidate. If the function returns false, the pair is dropped.
  std::function<bool(const CandidatePair&)> accept{};
  /// If set, it is called with every pair that was a candidate and no longer is (PairEvent::end, without triangles), by
  /// the ids that the pair had. The calls come in the order of the candidates and between their visits; of two pairs
  /// with the same indices, the ended pair comes first.
  std::function<void(const CandidatePair&)> ended{};
  /// Threads for the tests of pairs and the collection of triangles. The results, their order and the statistics do not
  /// depend on it. By default only the calling thread works.
  Executor executor{};
};

/// Numbers of pairs. All but the last two depend on the bodies and options alone.
struct CandidateStatistics {
  std::int64_t overlapping = 0;             ///< allowed by filters, not asleep, world boxes not proven apart
  std::int64_t refused = 0;                 ///< of these, the pairs refused by CandidateOptions::accept
  std::array<std::int64_t, 3> separated{};  ///< of these, the pairs proven separated by each Stage
  std::int64_t candidates = 0;              ///< of these, the remaining pairs
  std::int64_t asked = 0;                   ///< pairs tested in this search; the others were tested in an earlier one
  /// Pairs that the search went through: pairs that filters allow, not asleep, whose boxes overlap now or at the
  /// largest margin so far.
  std::int64_t listed = 0;
};

/// What holds for all bodies of a world.
struct WorldOptions {
  /// True if each body's arc_margin() about its BodyOptions::pivot is added to the margin of its pairs: candidates are
  /// then all pairs that may touch while the bodies really turn, at uniform angular velocity, from the start to the end
  /// pose. By default the world takes vertices to move on straight lines, so that a rod that turns by 90 degrees may
  /// sweep over a post without being a candidate; where that matters, keep rotations small or set this, and pass the
  /// sum of both arc_margin() to first_contact(), too, as ContactOptions::arc. Two poses do not tell turns of 180
  /// degrees and more (Motion).
  bool arcs = false;
  /// Without unit, in [0, 0.1], usually 0 or 1e-4: the world corrects poses that are farther than 1e-9 from rigid by
  /// nearest_rigid(), if the deviation is at most this, and adds correction_margin() to the margin of the body's pairs.
  /// So nothing is missed of what the body touches at the pose as given. Rotations in float deviate by some 1e-7. By
  /// default such poses throw Error.
  double pose_tolerance = 0;
};

/// Numbers of bodies.
struct BodyCounts {
  std::int64_t dynamic = 0, kinematic = 0, static_ = 0;
  std::int64_t awake = 0;
  std::int64_t sensors = 0;
  std::int64_t corrected = 0;  ///< whose poses have been corrected (WorldOptions::pose_tolerance)
};

class WorldSnapshot;

/// Bodies and half-spaces, and the search for pairs that may come into contact during a step. The search tests only
/// pairs of which a body has changed since the previous search; an unchanged pair costs some nanoseconds.
///
/// *Sleep.* Bodies are awake until the caller puts them to sleep; the world itself wakes none. The search leaves out a
/// pair of two bodies that are asleep or static (or of one and a half-space) once it has tested the pair after the last
/// change of either body; such a pair costs nothing. Nothing is missed, because the pair has not changed. A kinematic
/// body is also awake until it is put to sleep, and its pairs with sleeping bodies are tested. A pair that is left out
/// has no events; when a body wakes or is changed, the pair persists or ends. A search with a larger margin than that
/// at which pairs were left out tests all of them once.
///
/// Candidates depend on shapes, motions, options and ids alone, not on the order of the calls that set them; events
/// depend on the candidates of the previous search, whatever its options. Bad input throws Error, which names the body,
/// the value and the reason, and leaves the world unchanged; so does std::bad_alloc. Lengths are in world units.
///
/// *Rotation.* Vertices move on straight lines between the poses of a step. WorldOptions::arcs adds what the arcs of
/// real rotation add; without it a pair that only the arcs bring together is not a candidate.
///
/// A world is used by one thread at a time: a search writes to its buffers. That search may borrow threads
/// (CandidateOptions::executor). Const functions may run in any number of threads at a time while no other function
/// does. Different worlds are independent, even with the same shapes.
class World {
 public:
  World();
  /// Throws Error for a bad pose_tolerance.
  explicit World(const WorldOptions& options);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// Adds a shape, which the world shares and keeps until it is removed. The margin, in [0, 1e150], is added to that of
  /// every pair of the shape's bodies. Throws Error for a null shape or a bad margin.
  ShapeId add_shape(ShapePtr shape, double margin = 0);

  /// Adds a body at rest, awake unless it is static. Throws Error for an unknown shape, a pose that is not finite,
  /// mirrors, or is farther than 1e-9 from rigid (WorldOptions::pose_tolerance admits more), and for bad options.
  BodyId add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options = {});

  /// Adds a half-space. Throws Error if the length of the normal differs from 1 by more than 1e-9, or if a number is
  /// not finite.
  HalfSpaceId add_half_space(const HalfSpace& half_space, const Filter& filter = {});

  void remove_shape(ShapeId shape);  ///< throws Error while a body uses the shape
  void remove_body(BodyId body);
  void remove_half_space(HalfSpaceId half_space);

  /// Sets a rest pose or the motion of the body in the next steps, until it is set again. The body turns the short way
  /// from the start to the end pose: two poses cannot distinguish 190 degrees from -170. Throws Error for a motion that
  /// is not usable (is_usable()), e.g. one whose poses are 180 degrees apart, for a static body that would not rest,
  /// and for a motion.scale that is neither 1 nor the body's; the body keeps its own scale in either case. Poses within
  /// WorldOptions::pose_tolerance are corrected first.
  void set_pose(BodyId body, const Eigen::Isometry3d& pose);
  void set_motion(BodyId body, const Motion& motion);

  void set_shape(BodyId body, ShapeId shape);
  /// Puts another shape in the place of a shape, for all its bodies at once, e.g. that of a mesh that deforms
  /// (refit_shape()). Pairs and their events go on. Linear in the number of bodies. Throws Error for a null shape.
  void set_shape(ShapeId id, ShapePtr shape);
  /// Sets all options at once. A body that becomes static falls asleep; one that ceases to be static wakes. Throws
  /// Error for bad options, and for a body that would become static while it moves.
  void set_options(BodyId body, const BodyOptions& options);
  void set_filter(BodyId body, const Filter& filter);
  void set_scale(BodyId body, double scale);

  /// Wakes a body or puts it to sleep. It has no effect on static bodies.
  void set_awake(BodyId body, bool awake);

  /// Sets how far, in [0, 1e150], points of the surface may be from where the motion takes them, in the next steps and
  /// until it is set again. Each vertex may be displaced by any vector up to this length, and its triangles follow;
  /// vertices at the same position are displaced alike. The bound is added to the margin of every pair of the body, so
  /// that every proof holds for the deformed body. Initially 0.
  void set_deformation(BodyId body, double bound);

  /// Sets a number for the caller, e.g. the address of the engine's own body. It has no effect on pairs. Initially 0.
  void set_user_data(BodyId body, std::uint64_t data);

  /// Brings the tree of bodies up to date with all changes, as the search does, for the queries of
  /// <encage/world_queries.h>: they ask bodies that have changed since one after the other. Pairs and events stay as
  /// they are. Under a microsecond for each body that has changed. Throws Error for a bad number of threads.
  void update_boxes(const Executor& executor = {});

  // References stay valid until the next call of a non-const function.
  const Motion& motion(BodyId body) const;  ///< as corrected
  /// Returns RigidPose::deviation of the body's poses, the larger one of a motion; 0 if they have not been corrected.
  double pose_deviation(BodyId body) const;
  /// Returns what the body adds to the margin of its pairs: the sum of BodyOptions::margin, its shape's margin, its
  /// deformation, the correction of its poses, and with WorldOptions::arcs its arc_margin().
  double pair_margin(BodyId body) const;
  std::uint64_t user_data(BodyId body) const;
  const BodyOptions& options(BodyId body) const;
  const ShapePtr& shape(BodyId body) const;
  ShapeId shape_id(BodyId body) const;
  bool is_awake(BodyId body) const;
  double deformation(BodyId body) const;
  const ShapePtr& shape(ShapeId shape) const;
  double margin(ShapeId shape) const;
  const HalfSpace& half_space(HalfSpaceId half_space) const;
  const WorldOptions& options() const noexcept;

  // True for an object that has been added and not removed.
  bool contains(ShapeId shape) const noexcept;
  bool contains(BodyId body) const noexcept;
  bool contains(HalfSpaceId half_space) const noexcept;
  // Removed objects do not count.
  std::int64_t shape_count() const noexcept;
  std::int64_t body_count() const noexcept;
  std::int64_t half_space_count() const noexcept;
  BodyCounts body_counts() const noexcept;  ///< linear time

  // All that exist, by increasing index.
  std::vector<ShapeId> shapes() const;
  std::vector<BodyId> bodies() const;
  std::vector<HalfSpaceId> half_spaces() const;

  /// Calls visit(const CandidatePair&) for every pair that filters allow, that is not left out for sleep, and that
  /// neither world boxes nor separated() prove separated. Pairs come by increasing index of a; for each a first the
  /// bodies b by increasing index, then the half-spaces. The pair and its triangles are valid during the call. visit,
  /// accept and ended may read the world; a call that changes it throws Error. The calling thread calls all three while
  /// no task runs. If one of them or the executor throws, the search ends, and the next search continues with the
  /// events that have not been delivered. Allocates nothing unless there are more pairs or triangles, sleeping or ended
  /// pairs than ever before; collecting triangles with an executor allocates 2 MiB once. Throws Error for a bad margin
  /// or number of threads.
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

  /// Returns a copy of the whole state of the world, for rollback: some 600 bytes for each body and 24 for each pair;
  /// shapes are shared. After restore() the same calls give the same ids, candidates, events and statistics as after
  /// the snapshot was taken.
  WorldSnapshot snapshot() const;
  /// Overwrites a snapshot. It allocates nothing if `reused` has stored as much before.
  void snapshot(WorldSnapshot& reused) const;
  /// Restores a snapshot of this or of another world, WorldOptions included. Allocates nothing if this world has stored
  /// as much before. Throws Error for an empty snapshot.
  void restore(const WorldSnapshot& snapshot);

 private:
  friend class WorldSnapshot;
  friend class WorldQuery;
  class State;
  std::unique_ptr<State> state_;
};

/// A state of a world, which World::snapshot() returns. Immutable except when it is overwritten: any number of threads
/// may restore from it.
class WorldSnapshot {
 public:
  WorldSnapshot();  ///< empty
  ~WorldSnapshot();
  WorldSnapshot(WorldSnapshot&&) noexcept;
  WorldSnapshot& operator=(WorldSnapshot&&) noexcept;

 private:
  friend class World;
  std::unique_ptr<World::State> state_;
};

}  // namespace encage
