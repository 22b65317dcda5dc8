// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/box_tree.h"
#include "broadphase/triangle_lists.h"

#include <encage/world.h>

#include <cstdint>
#include <vector>

namespace encage {

/// What a World holds. A tree of enlarged boxes finds pairs of bodies once, when
/// one of them leaves its box; the pairs are kept, sorted, with what was last proven about them.
class [[gnu::visibility("hidden")]] World::State {
 public:
  ShapeId add_shape(ShapePtr shape);
  BodyId add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options);
  HalfSpaceId add_half_space(const HalfSpace& half_space, const Filter& filter);
  void remove_body(BodyId body);
  void set_pose(BodyId body, const Eigen::Isometry3d& pose);
  void set_motion(BodyId body, const Motion& motion);
  CandidateStatistics search(const CandidateOptions& options, void (*visit)(void*, const CandidatePair&),
                             void* context);

  struct Body {
    Motion motion;
    BodyOptions options;
    Eigen::AlignedBox3d box;   // world_box(), where box_of is changed_at
    std::uint64_t box_of = 0;  // the time of the motion that `box` is about; atomic during a search
    ShapeId shape{};
    BoxTree::Leaf leaf = -1;  // -1: removed
  };
  const Body& body(BodyId id) const;  // throws Error for an unknown or a removed one
  const ShapePtr& shape(BodyId id) const { return shapes_[static_cast<std::uint32_t>(body(id).shape)].shape; }
  const HalfSpace& half_space(HalfSpaceId id) const;
  bool contains(BodyId id) const noexcept;

  std::int64_t shape_count() const noexcept { return static_cast<std::int64_t>(shapes_.size()); }
  std::int64_t body_count() const noexcept { return tree_.size(); }
  std::int64_t half_space_count() const noexcept { return static_cast<std::int64_t>(planes_.size()); }

 private:
  struct SharedShape {
    ShapePtr shape;
    Eigen::AlignedBox3d box;  // in the body frame
  };
  struct Plane {
    HalfSpace half_space;
    Filter filter;
  };
  // What every search reads of every body.
  struct Bounds {
    Eigen::AlignedBox3d loose;  // contains the body during its motion, cheap to compute
    double margin = 0;
    std::uint64_t changed_at = 0;
  };
  // Boxes for the tree: what must be inside, and what is worth having.
  struct TreeBoxes {
    FloatBox tight;
    FloatBox fat;
  };
  struct Pair {
    std::uint64_t key = 0;        // sorts the pairs
    std::uint64_t tested_at = 0;  // the time of what follows
    Verdict verdict{};            // if asked
    bool apart = false;           // boxes are
    bool asked = false;
    bool counted = false;  // by CandidateStatistics::asked
    bool refused = false;  // by CandidateOptions::accept, if this search has one
  };
  class Search;

  static constexpr std::uint32_t half_space_bit = 0x80000000;
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }
  static std::uint32_t first(const Pair& pair) { return static_cast<std::uint32_t>(pair.key >> 32); }
  static std::uint32_t second(const Pair& pair) { return static_cast<std::uint32_t>(pair.key); }
  static bool has_half_space(const Pair& pair) { return (pair.key & half_space_bit) != 0; }

  void check_unlocked() const;
  Eigen::AlignedBox3d loose_box(ShapeId shape, const Motion& motion) const;
  TreeBoxes tree_boxes(ShapeId shape, const Motion& motion, const BodyOptions& options,
                       const Eigen::AlignedBox3d& loose) const;

  void collect(double margin);
  void find_fresh_pairs(double margin);
  void find_fresh_half_spaces(std::uint32_t body, std::size_t first_plane, double margin);
  void merge_fresh_pairs();
  bool allowed(const Body& a, const Body& b) const noexcept;

  double margin_of(const Pair& pair, double margin) const noexcept;
  bool is_current(const Pair& pair) const noexcept;
  // Tasks of a search call these at the same time, for different pairs.
  bool boxes_are_apart(const Pair& pair, double margin) noexcept;
  Eigen::AlignedBox3d tight_box(std::uint32_t body) noexcept;
  Verdict ask(const Pair& pair, PairOptions options) const noexcept;
  template <class Visit>
  void for_each_triangle_pair(const Pair& pair, double margin, Visit&& visit) const;
  CandidatePair candidate(const Pair& pair) const noexcept;

  std::vector<SharedShape> shapes_;
  std::vector<Plane> planes_;
  std::vector<Body> bodies_;
  std::vector<Bounds> bounds_;          // of bodies_
  std::vector<std::uint8_t> outdated_;  // bodies that left their place in the tree since their pairs were collected
  BoxTree tree_;
  std::uint64_t clock_ = 0;        // counts changes and searches
  std::uint64_t complete_at_ = 0;  // the last search that left no pair unasked
  bool searching_ = false;

  std::vector<Pair> pairs_;  // all that are allowed and whose tree boxes overlap, by key
  std::vector<Pair> merged_;
  std::vector<std::uint64_t> fresh_;
  bool has_stale_pairs_ = false;      // of removed bodies
  std::size_t collected_planes_ = 0;  // pairs_ knows the first ones
  double collected_margin_ = 0;       // pairs_ is complete up to this one
  PairOptions last_options_;
  std::uint64_t options_changed_at_ = 0;

  std::vector<TrianglePair> triangles_;    // of one pair
  TriangleLists lists_;                    // of pairs that tasks went through
  std::vector<TriangleLists::List> list_;  // of pairs_
};

}  // namespace encage
