// SPDX-License-Identifier: Apache-2.0
#include "broadphase/body_box.h"
#include "broadphase/frame.h"
#include "broadphase/world_state.h"

#include <algorithm>

namespace encage {
namespace {

bool same(const PairOptions& a, const PairOptions& b) {
  return a.margin == b.margin && a.cages == b.cages && a.finest_cage == b.finest_cage &&
         a.coarsest_cage == b.coarsest_cage && a.fine == b.fine;
}

bool masks_allow(const Filter& a, const Filter& b) { return (a.category & b.mask) != 0 && (b.category & a.mask) != 0; }

Eigen::AlignedBox3d in_double(const FloatBox& box) {
  return {Eigen::Map<const Eigen::Vector3f>(box.lower.data()).cast<double>(),
          Eigen::Map<const Eigen::Vector3f>(box.upper.data()).cast<double>()};
}

/// By half as much again as before: few steps grow, then none.
template <class T>
void make_room(std::vector<T>& v, std::size_t size) {
  if (v.capacity() < size) v.reserve(std::max(size, v.capacity() + v.capacity() / 2));
}

}  // namespace

/// Locks the world while its pairs are visited.
class World::State::Searching {
 public:
  explicit Searching(State& state) : state_(state) { state_.searching_ = true; }
  ~Searching() { state_.searching_ = false; }
  Searching(const Searching&) = delete;
  Searching& operator=(const Searching&) = delete;

 private:
  State& state_;
};

// ---- Pairs whose tree boxes overlap --------------------------------------

bool World::State::allowed(const Body& a, const Body& b) const noexcept {
  if (a.options.is_static && b.options.is_static) return false;
  if (a.options.group != 0 && a.options.group == b.options.group) return a.options.group > 0;
  return masks_allow(a.options.filter, b.options.filter);
}

void World::State::find_fresh_half_spaces(std::uint32_t n, std::size_t first_plane, double margin) {
  const Body& body = bodies_[n];
  if (body.options.is_static) return;
  const Eigen::AlignedBox3d box = in_double(tree_.box(body.leaf));
  for (std::size_t p = first_plane; p < planes_.size(); ++p) {
    // The box holds the body's margin already; twice is safe.
    if (masks_allow(body.options.filter, planes_[p].filter) &&
        !box_beyond(box, planes_[p].half_space, margin + body.options.margin)) {
      fresh_.push_back(key(n, half_space_bit | static_cast<std::uint32_t>(p)));
    }
  }
}

void World::State::find_fresh_pairs(double margin) {
  fresh_.clear();
  tree_.query_moved_pairs(margin * (1 + 1e-12), [&](std::uint32_t a, std::uint32_t b) {
    if (allowed(bodies_[a], bodies_[b])) fresh_.push_back(key(std::min(a, b), std::max(a, b)));
  });
  for (const BoxTree::Leaf leaf : tree_.moved()) find_fresh_half_spaces(tree_.item(leaf), 0, margin);
  if (collected_planes_ < planes_.size()) {
    for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
      if (outdated_[n] == 0) find_fresh_half_spaces(n, collected_planes_, margin);
    }
  }
  std::sort(fresh_.begin(), fresh_.end());
}

void World::State::merge_fresh_pairs() {
  merged_.clear();
  make_room(merged_, pairs_.size() + fresh_.size());
  auto fresh = fresh_.cbegin();
  for (const Pair& pair : pairs_) {
    if (outdated_[first(pair)] != 0 || (!has_half_space(pair) && outdated_[second(pair)] != 0)) continue;
    for (; fresh != fresh_.cend() && *fresh < pair.key; ++fresh) merged_.push_back({.key = *fresh});
    merged_.push_back(pair);
  }
  for (; fresh != fresh_.cend(); ++fresh) merged_.push_back({.key = *fresh});
  pairs_.swap(merged_);
}

void World::State::collect(double margin) {
  if (margin > collected_margin_) {
    for (std::size_t n = 0; n < bodies_.size(); ++n) {
      if (bodies_[n].leaf >= 0) tree_.touch(bodies_[n].leaf);
      outdated_[n] = 1;
    }
    collected_margin_ = margin;
  }
  if (tree_.moved().empty() && !has_stale_pairs_ && collected_planes_ == planes_.size()) return;
  // Nothing of the following is lost if memory runs out.
  find_fresh_pairs(collected_margin_);
  merge_fresh_pairs();
  for (const BoxTree::Leaf leaf : tree_.moved()) outdated_[tree_.item(leaf)] = 0;
  tree_.clear_moved();
  has_stale_pairs_ = false;
  collected_planes_ = planes_.size();
}

// ---- One pair ------------------------------------------------------------

double World::State::margin_of(const Pair& pair, double margin) const noexcept {
  const double sum = margin + bounds_[first(pair)].margin;
  return has_half_space(pair) ? sum : sum + bounds_[second(pair)].margin;
}

bool World::State::is_current(const Pair& pair) const noexcept {
  std::uint64_t changed_at = std::max(options_changed_at_, bounds_[first(pair)].changed_at);
  if (!has_half_space(pair)) changed_at = std::max(changed_at, bounds_[second(pair)].changed_at);
  return pair.tested_at > changed_at;
}

const Eigen::AlignedBox3d& World::State::tight_box(std::uint32_t n) noexcept {
  Body& body = bodies_[n];
  if (body.box_of != bounds_[n].changed_at) {
    body.box = world_box(*shapes_[static_cast<std::uint32_t>(body.shape)].shape, body.motion);
    body.box_of = bounds_[n].changed_at;
  }
  return body.box;
}

bool World::State::boxes_are_apart(const Pair& pair, double margin) noexcept {
  const std::uint32_t a = first(pair), b = second(pair);
  if (has_half_space(pair)) {
    const HalfSpace& plane = planes_[b & ~half_space_bit].half_space;
    return box_beyond(bounds_[a].loose, plane, margin) || box_beyond(tight_box(a), plane, margin);
  }
  return boxes_apart(bounds_[a].loose, bounds_[b].loose, margin) || boxes_apart(tight_box(a), tight_box(b), margin);
}

CandidatePair World::State::candidate(const Pair& pair) const noexcept {
  CandidatePair result;
  result.a = static_cast<BodyId>(first(pair));
  if (has_half_space(pair)) {
    result.half_space = static_cast<HalfSpaceId>(second(pair) & ~half_space_bit);
  } else {
    result.b = static_cast<BodyId>(second(pair));
  }
  return result;
}

Verdict World::State::ask(const Pair& pair, PairOptions options) const noexcept {
  const Body& a = bodies_[first(pair)];
  const Shape& shape_a = *shapes_[static_cast<std::uint32_t>(a.shape)].shape;
  options.margin = margin_of(pair, options.margin);
  options.boxes = false;  // boxes_are_apart() has
  if (has_half_space(pair)) {
    return separated(shape_a, a.motion, planes_[second(pair) & ~half_space_bit].half_space, options.margin);
  }
  const Body& b = bodies_[second(pair)];
  return separated(shape_a, a.motion, *shapes_[static_cast<std::uint32_t>(b.shape)].shape, b.motion, options);
}

std::span<const TrianglePair> World::State::triangles(const Pair& pair, double margin) {
  triangles_.clear();
  if (has_half_space(pair)) return {};
  const Body& a = bodies_[first(pair)];
  const Body& b = bodies_[second(pair)];
  for_each_candidate(*shapes_[static_cast<std::uint32_t>(a.shape)].shape, a.motion,
                     *shapes_[static_cast<std::uint32_t>(b.shape)].shape, b.motion, margin_of(pair, margin),
                     [this](TrianglePair found) {
                       triangles_.push_back(found);
                       return true;
                     });
  return triangles_;
}

// ---- Search --------------------------------------------------------------

CandidateStatistics World::State::search(const CandidateOptions& options, void (*visit)(void*, const CandidatePair&),
                                         void* context) {
  check_unlocked();
  if (!(options.pair.margin >= 0 && options.pair.margin <= 1e150)) {
    throw Error("candidate options: the margin is negative or not finite");
  }
  const Searching lock(*this);
  collect(options.pair.margin);
  if (!same(options.pair, last_options_)) {
    last_options_ = options.pair;
    options_changed_at_ = ++clock_;
  }
  const std::uint64_t now = ++clock_;
  CandidateStatistics counts;
  for (Pair& pair : pairs_) {
    if (!is_current(pair)) {
      pair.apart = boxes_are_apart(pair, margin_of(pair, options.pair.margin));
      pair.asked = false;
      pair.tested_at = now;
    }
    if (pair.apart) continue;
    ++counts.overlapping;
    CandidatePair result = candidate(pair);
    if (options.accept && !options.accept(result)) {
      ++counts.refused;
      continue;
    }
    if (!pair.asked) {
      pair.verdict = ask(pair, options.pair);
      pair.asked = true;
      ++counts.asked;
    }
    result.verdict = pair.verdict;
    if (pair.verdict.separated) {
      ++counts.separated[static_cast<std::size_t>(pair.verdict.stage)];
      continue;
    }
    ++counts.candidates;
    if (options.triangles) result.triangles = triangles(pair, options.pair.margin);
    visit(context, result);
  }
  return counts;
}

}  // namespace encage
