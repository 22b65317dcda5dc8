// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/world/body_tree.h"
#include "broadphase/world/id_table.h"
#include "broadphase/world/key_order.h"
#include "broadphase/world/pair_key.h"
#include "broadphase/world/sleeping_pairs.h"
#include "broadphase/world/triangle_lists.h"

#include <encage/world.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace encage {

/// Explains why a length is refused, e.g. "the margin -1 is negative"; empty if it is accepted.
std::string length_defect(const char* what, double length);

/// The content of a World; a copy of it is a snapshot. A tree of boxes finds the pairs of the bodies that have changed.
/// Pairs are kept, sorted, with their last verdict.
///
/// A body is *active* while it is awake, or if it was changed after the last complete search. Pairs without an active
/// body are not kept, except that the state records which of them were candidates.
class ENCAGE_HIDDEN World::State {
 public:
  State() = default;
  explicit State(const WorldOptions& options);

  ShapeId add_shape(ShapePtr shape, double margin);
  BodyId add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options);
  HalfSpaceId add_half_space(const HalfSpace& half_space, const Filter& filter);
  void remove(ShapeId id);
  void remove(BodyId id);
  void remove(HalfSpaceId id);
  void set_pose(BodyId body, const Eigen::Isometry3d& pose);
  void set_motion(BodyId body, const Motion& motion);
  void set_shape(BodyId body, ShapeId shape);
  void set_shape(ShapeId id, ShapePtr replacement);
  void set_options(BodyId body, const BodyOptions& options);
  void set_awake(BodyId body, bool awake);
  void set_deformation(BodyId body, double bound);
  void set_user_data(BodyId body, std::uint64_t data);
  void update_boxes(const Executor& executor);
  CandidateStatistics search(const CandidateOptions& options, void (*visit)(void*, const CandidatePair&),
                             void* context);
  /// Becomes equal to another state without losing capacity. If it throws, nothing has changed.
  void assign(const State& other);
  void check_unlocked() const;

  struct Body {
    Motion motion;
    BodyOptions options;
    double deformation = 0;
    double deviation = 0;  // of the motion from the poses as given
    std::uint64_t user_data = 0;
    bool awake = true;  // never for a static body
    ShapeId shape{};
    BodyTree::Leaf leaf = -1;
  };
  struct SharedShape {
    ShapePtr shape;
    Eigen::AlignedBox3d box;  // in the body frame
    double margin = 0;
    std::int64_t bodies = 0;
  };
  struct Plane {
    HalfSpace half_space;
    Filter filter;
    std::uint64_t changed_at = 0;
  };
  // These throw Error for an id that is unknown or removed.
  const Body& body(BodyId id) const;
  const SharedShape& shape(ShapeId id) const;
  const Plane& half_space(HalfSpaceId id) const;

  // For queries, which know indices only.
  const BodyTree& tree() const noexcept { return tree_; }
  const Body& body_at(std::uint32_t n) const noexcept { return bodies_[n]; }
  const Plane& plane_at(std::uint32_t p) const noexcept { return planes_[p]; }
  const Shape& shape_at(std::uint32_t n) const noexcept { return *shape_of(bodies_[n]); }

  const WorldOptions& options() const noexcept { return options_; }
  BodyCounts body_counts() const noexcept;

  double pair_margin(BodyId id) const { return own_margin(body(id)); }

  const IdTable<ShapeId>& shape_ids() const noexcept { return shape_ids_; }
  const IdTable<BodyId>& body_ids() const noexcept { return body_ids_; }
  const IdTable<HalfSpaceId>& plane_ids() const noexcept { return plane_ids_; }

 private:
  // The data of every body that every search reads.
  struct alignas(64) Bounds {
    Eigen::AlignedBox3d box;  // world_box(), once pairs are collected
    double margin = 0;        // sum of the body's own margins
    std::uint64_t changed_at = 0;
  };
  // Bits of traits_.
  static constexpr std::uint8_t is_awake = 1;
  static constexpr std::uint8_t is_plain = 2;  // forms pairs with every other plain body
  static constexpr std::uint8_t is_compound = 4;
  struct Pair {
    std::uint64_t key = 0;
    std::uint64_t tested_at = 0;  // time of the following members; 0 if a body has changed since
    Verdict verdict{};            // valid if `asked`
    bool apart : 1 = false;       // by their boxes
    bool asked : 1 = false;
    bool counted : 1 = false;    // by CandidateStatistics::asked
    bool refused : 1 = false;    // by CandidateOptions::accept, if this search has one
    bool candidate : 1 = false;  // in the previous search, or in this one once it has come to the pair
  };
  // A pair that was a candidate and is no longer kept.
  struct Ended {
    std::uint64_t key = 0;
    BodyId a{}, b{};
    HalfSpaceId half_space{};
    bool apart = false;  // by their boxes
    // NOLINTNEXTLINE(modernize-use-nullptr): what the compiler writes for it
    friend auto operator<=>(const Ended&, const Ended&) = default;
  };
  // Data that do not outlast a call and are not copied.
  struct Scratch {
    Scratch() = default;
    Scratch(const Scratch&) {}
    Scratch& operator=(const Scratch&) { return *this; }

    bool searching = false;
    std::vector<Pair> merged;
    std::vector<std::uint64_t> fresh, woken;  // keys
    KeyOrder order;
    std::vector<std::uint8_t> status;       // of bodies, while pairs are merged
    std::vector<TrianglePair> triangles;    // of one pair
    TriangleLists lists;                    // of pairs that tasks went through
    std::vector<TriangleLists::List> list;  // of pairs
  };
  class Search;

  static constexpr std::uint8_t outdated = 1, listed_as_removed = 2;  // bits of outdated_
  static constexpr std::uint8_t still_same = 2, active = 4;           // the bits of a status, with `outdated`

  const ShapePtr& shape_of(const Body& body) const { return shapes_[index(body.shape)].shape; }
  void check_options(BodyId id, const BodyOptions& options) const;
  /// Returns how far the correction moves points, without unit; 0 if there was none. Throws Error for a pose that is
  /// neither usable nor within the tolerance.
  double correct(Eigen::Isometry3d& pose, BodyId body, const char* which) const;
  void move(BodyId body, const Motion& motion, double deviation);
  double own_margin(const Body& body) const noexcept;
  FloatBox tree_box(const Bounds& bounds) const noexcept;
  void update(std::uint32_t body) noexcept;

  // Functions for the pairs whose tree boxes overlap.
  void stir_sleepers() noexcept;
  void collect(double margin, const Executor& executor);
  void find_boxes(const Executor& executor);
  void find_fresh_pairs(double margin);
  void find_fresh_half_spaces(std::uint32_t body, bool outdated_ones, double margin);
  template <class Visit>
  void for_each_woken(Visit&& visit) const;
  void prepare_merge();
  void merge_pairs(bool tested) noexcept;
  void note_collected() noexcept;
  static bool meets_half_spaces(const BodyOptions& options) noexcept;
  bool allowed(std::uint32_t a, std::uint32_t b) const noexcept;
  bool allowed(std::uint64_t key) const noexcept;
  bool is_active(std::uint32_t body) const noexcept;
  bool is_active(std::uint64_t key) const noexcept;
  void note_status();
  std::uint8_t status(std::uint32_t body) const noexcept;
  std::uint8_t status(std::uint64_t key) const noexcept;
  Ended ended(std::uint64_t key) const noexcept;

  double margin_of(std::uint64_t key, double margin) const noexcept;
  bool is_current(const Pair& pair) const noexcept;
  // Tasks of a search call these functions at the same time, for different pairs.
  bool boxes_are_apart(std::uint64_t key, double margin) const noexcept;
  Verdict ask(const Pair& pair, PairOptions options) const noexcept;
  template <class Visit>
  void for_each_triangle_pair(const Pair& pair, double margin, Visit&& visit) const;
  CandidatePair candidate(const Pair& pair) const noexcept;

  WorldOptions options_;
  IdTable<ShapeId> shape_ids_;
  IdTable<BodyId> body_ids_;
  IdTable<HalfSpaceId> plane_ids_;
  // These are indexed by ids' indices.
  std::vector<SharedShape> shapes_;
  std::vector<Plane> planes_;
  std::vector<Body> bodies_;
  std::vector<Bounds> bounds_;
  std::vector<std::uint8_t> traits_;  // few bytes, read for every pair found
  // Nonzero for objects that were added, removed, woken or changed since pairs were collected.
  std::vector<std::uint8_t> outdated_, outdated_planes_;
  std::vector<BodyId> collected_;              // the bodies whose pairs are known
  std::vector<HalfSpaceId> collected_planes_;  // the same for half-spaces
  std::vector<std::uint32_t> removed_;         // bodies removed since pairs were collected

  BodyTree tree_;
  std::uint64_t clock_ = 0;        // counts changes and searches
  std::uint64_t searched_at_ = 0;  // time of the last search that came to its end
  std::uint64_t complete_at_ = 0;  // time of the last search that tested all pairs
  // The least margin at which pairs have been left out.
  double left_out_margin_ = std::numeric_limits<double>::infinity();
  bool has_stirred_ = false;  // something is active only because it was changed

  std::vector<Pair> pairs_;  // all that are allowed and whose tree boxes overlap, sorted by key
  SleepingPairs sleeping_;   // candidates that the search leaves out
  std::vector<Ended> ended_;
  std::size_t ended_visited_ = 0;
  bool has_stale_pairs_ = false;  // of objects that were removed or fell asleep
  bool has_outdated_planes_ = false;
  double collected_margin_ = 0;  // pairs_ is complete up to this margin
  PairOptions last_options_;
  std::uint64_t options_changed_at_ = 0;
  Scratch scratch_;
};

}  // namespace encage
