// SPDX-License-Identifier: Apache-2.0
// A world keeps the pairs whose boxes in the tree overlap.
#include "broadphase/motion/turned_box.h"
#include "broadphase/shape/world_box.h"
#include "broadphase/world/chunks.h"
#include "broadphase/world/room.h"
#include "broadphase/world/state.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>
#include <limits>

namespace encage {
namespace {

bool masks_allow(const Filter& a, const Filter& b) { return (a.category & b.mask) != 0 && (b.category & a.mask) != 0; }

Eigen::AlignedBox3d in_double(const FloatBox& box) {
  return {Eigen::Map<const Eigen::Vector3f>(box.lower.data()).cast<double>(),
          Eigen::Map<const Eigen::Vector3f>(box.upper.data()).cast<double>()};
}

}  // namespace

// ---- What is true of a pair ----------------------------------------------

bool World::State::meets_half_spaces(const BodyOptions& options) noexcept {
  return options.kind == BodyKind::dynamic || (options.sensor && options.kind == BodyKind::kinematic);
}

bool World::State::allowed(std::uint32_t n, std::uint32_t m) const noexcept {
  if ((traits_[n] & traits_[m] & is_plain) != 0) return true;
  const BodyOptions &a = bodies_[n].options, &b = bodies_[m].options;
  if (a.kind != BodyKind::dynamic && b.kind != BodyKind::dynamic &&
      (!(a.sensor || b.sensor) || (a.kind == BodyKind::static_ && b.kind == BodyKind::static_))) {
    return false;
  }
  if (a.group != 0 && a.group == b.group) return a.group > 0;
  return masks_allow(a.filter, b.filter);
}

bool World::State::allowed(std::uint64_t key) const noexcept {
  const std::uint32_t n = first_of(key);
  if (!has_half_space(key)) return allowed(n, second_of(key));
  const BodyOptions& options = bodies_[n].options;
  return meets_half_spaces(options) && masks_allow(options.filter, planes_[half_space_of(key)].filter);
}

bool World::State::is_active(std::uint32_t n) const noexcept {
  return (traits_[n] & is_awake) != 0 || bounds_[n].changed_at > searched_at_;
}

bool World::State::is_active(std::uint64_t key) const noexcept {
  if (is_active(first_of(key))) return true;
  return has_half_space(key) ? planes_[half_space_of(key)].changed_at > searched_at_ : is_active(second_of(key));
}

std::uint8_t World::State::status(std::uint32_t n) const noexcept {
  // `still_same` means: the body with this index is still the one whose pairs are known.
  return static_cast<std::uint8_t>((body_ids_.contains(collected_[n]) ? still_same : 0) | (is_active(n) ? active : 0) |
                                   (outdated_[n] != 0 ? outdated : 0));
}

/// Computes the status of every body once, if merging needs it many times.
void World::State::note_status() {
  std::vector<std::uint8_t>& all = scratch_.status;
  all.clear();
  if (pairs_.size() < bodies_.size() / 4) return;
  make_room(all, bodies_.size());
  for (std::uint32_t n = 0; n < bodies_.size(); ++n) all.push_back(status(n));
}

/// `still_same` is set if it is for both, the other bits if they are for one.
std::uint8_t World::State::status(std::uint64_t key) const noexcept {
  const auto of = [this](std::uint32_t n) { return scratch_.status.empty() ? status(n) : scratch_.status[n]; };
  const std::uint8_t a = of(first_of(key));
  std::uint8_t b = 0;
  if (has_half_space(key)) {
    const std::uint32_t p = half_space_of(key);
    b = static_cast<std::uint8_t>((plane_ids_.contains(collected_planes_[p]) ? still_same : 0) |
                                  (planes_[p].changed_at > searched_at_ ? active : 0) |
                                  (outdated_planes_[p] != 0 ? outdated : 0));
  } else {
    b = of(second_of(key));
  }
  return static_cast<std::uint8_t>((a & b & still_same) | ((a | b) & (active | outdated)));
}

World::State::Ended World::State::ended(std::uint64_t key) const noexcept {
  const BodyId a = collected_[first_of(key)];
  if (has_half_space(key)) return {key, a, BodyId::none, collected_planes_[half_space_of(key)], false};
  return {key, a, collected_[second_of(key)], HalfSpaceId::none, false};
}

// ---- Pairs that are not known yet ----------------------------------------

void World::State::find_fresh_half_spaces(std::uint32_t n, bool outdated_ones, double margin) {
  const BodyOptions& options = bodies_[n].options;
  if (!meets_half_spaces(options)) return;
  const Eigen::AlignedBox3d box = in_double(tree_.box(bodies_[n].leaf));
  for (std::uint32_t p = 0; p < planes_.size(); ++p) {
    if (!plane_ids_.is_used(p) || (outdated_ones && outdated_planes_[p] == 0)) continue;
    const std::uint64_t key = pair_key(n, half_space_bit | p);
    // The box includes the body's margin already; adding it twice is safe.
    if (masks_allow(options.filter, planes_[p].filter) && is_active(key) &&
        !box_beyond(box, planes_[p].half_space, margin + bounds_[n].margin)) {
      scratch_.fresh.push_back(key);
    }
  }
}

void World::State::find_fresh_pairs(double margin) {
  scratch_.fresh.clear();
  // Pairs come in the order of positions in the tree, so neighbouring pairs share bodies. A pair's boxes are prefetched
  // and compared some pairs later.
  std::array<std::uint64_t, 32> waiting;
  std::size_t count = 0;
  const auto look = [&] {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint64_t key = waiting[i];
      const std::uint32_t a = first_of(key), b = second_of(key);
      if (!allowed(a, b) || !(is_active(a) || is_active(b))) continue;
      if (!boxes_are_apart(key, margin_of(key, margin))) scratch_.fresh.push_back(key);
    }
    count = 0;
  };
  tree_.query_moved_pairs(margin * (1 + 1e-12), [&](std::uint32_t a, std::uint32_t b) {
    hwy::Prefetch(&bounds_[a]);
    hwy::Prefetch(&bounds_[b]);
    waiting[count++] = pair_key(a, b);
    if (count == waiting.size()) look();
  });
  look();
  if (plane_ids_.size() > 0) {
    for (const BodyTree::Leaf leaf : tree_.moved()) find_fresh_half_spaces(tree_.item(leaf), false, margin);
  }
  if (has_outdated_planes_) {
    for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
      if (outdated_[n] == 0 && body_ids_.is_used(n)) find_fresh_half_spaces(n, true, margin);
    }
  }
  scratch_.order.sort(scratch_.fresh, bodies_.size());
}

// ---- Merging -------------------------------------------------------------

/// Calls visit for each body and half-space whose sleeping pairs have to be tested.
template <class Visit>
void World::State::for_each_woken(Visit&& visit) const {
  for (const BodyTree::Leaf leaf : tree_.moved()) {
    if (is_active(tree_.item(leaf))) visit(tree_.item(leaf));
  }
  for (const std::uint32_t n : removed_) visit(n);
  if (!has_outdated_planes_) return;
  for (std::uint32_t p = 0; p < planes_.size(); ++p) {
    if (outdated_planes_[p] != 0) visit(half_space_bit | p);
  }
}

/// After this, merge_pairs() cannot throw.
void World::State::prepare_merge() {
  ended_.erase(ended_.begin(), ended_.begin() + static_cast<std::ptrdiff_t>(ended_visited_));
  ended_visited_ = 0;
  note_status();
  std::size_t woken = 0, asleep = 0, ended = 0;
  for_each_woken([&](std::uint32_t owner) { woken += sleeping_.count(owner); });
  for (const Pair& pair : pairs_) {
    if (!pair.candidate) continue;
    const std::uint8_t is = status(pair.key);
    if ((is & still_same) != 0 && (is & active) == 0) ++asleep;
    if ((is & still_same) == 0 || (is & outdated) != 0) ++ended;
  }
  make_room(scratch_.woken, woken);
  make_room(scratch_.merged, pairs_.size() + woken + scratch_.fresh.size());
  make_room(ended_, ended_.size() + woken + ended);
  sleeping_.prepare_add(bodies_.size(), planes_.size(), asleep);
}

/// Merges three sorted lists: the known pairs that are awake, those that wake, and the pairs found. With `tested`, the
/// boxes of fresh pairs of bodies are known not to be apart.
void World::State::merge_pairs(bool tested) noexcept {
  const std::uint64_t now = ++clock_;
  std::vector<Pair>& merged = scratch_.merged;
  merged.clear();
  auto fresh = scratch_.fresh.cbegin();
  const auto fresh_end = scratch_.fresh.cend();
  const auto add = [&](std::uint64_t key, bool candidate) {
    merged.push_back({.key = key, .tested_at = tested && !has_half_space(key) ? now : 0, .candidate = candidate});
  };
  const auto settle = [&](const Pair& known) {
    for (; fresh != fresh_end && *fresh < known.key; ++fresh) add(*fresh, false);
    const std::uint8_t is = status(known.key);
    if ((is & still_same) == 0) {
      if (known.candidate) ended_.push_back(ended(known.key));
      return;  // a pair found with the same key is another one
    }
    if ((is & active) == 0) {
      if (known.candidate) sleeping_.add(known.key);
      return;
    }
    const bool found = fresh != fresh_end && *fresh == known.key;
    if (found) ++fresh;
    if ((is & outdated) == 0) {
      merged.push_back(known);
    } else if (found) {
      add(known.key, known.candidate);
    } else if (known.candidate) {
      ended_.push_back(ended(known.key));
      ended_.back().apart = allowed(known.key);
    }
  };

  std::vector<std::uint64_t>& woken = scratch_.woken;
  woken.clear();
  for_each_woken([&](std::uint32_t owner) { sleeping_.take(owner, [&](std::uint64_t key) { woken.push_back(key); }); });
  std::sort(woken.begin(), woken.end());
  auto next = woken.cbegin();
  for (const Pair& pair : pairs_) {
    for (; next != woken.cend() && *next < pair.key; ++next) settle({.key = *next, .candidate = true});
    settle(pair);
  }
  for (; next != woken.cend(); ++next) settle({.key = *next, .candidate = true});
  for (; fresh != fresh_end; ++fresh) add(*fresh, false);
  pairs_.swap(merged);
  std::sort(ended_.begin(), ended_.end());
}

void World::State::note_collected() noexcept {
  for (const std::uint32_t n : removed_) outdated_[n] = 0;
  removed_.clear();
  for (const BodyTree::Leaf leaf : tree_.moved()) {
    const std::uint32_t n = tree_.item(leaf);
    outdated_[n] = 0;
    collected_[n] = body_ids_.at(n);
  }
  tree_.clear_moved();
  if (has_outdated_planes_) {
    for (std::uint32_t p = 0; p < planes_.size(); ++p) {
      if (outdated_planes_[p] != 0) collected_planes_[p] = plane_ids_.at(p);
      outdated_planes_[p] = 0;
    }
  }
  has_stale_pairs_ = has_outdated_planes_ = false;
}

/// Makes the next search test the pairs that were left out, once, as if all bodies had changed.
void World::State::stir_sleepers() noexcept {
  searched_at_ = 0;
  left_out_margin_ = std::numeric_limits<double>::infinity();
  for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
    // Static bodies need no search: the other body finds the pair.
    if (!body_ids_.is_used(n) || bodies_[n].awake || bodies_[n].options.kind == BodyKind::static_) continue;
    tree_.touch(bodies_[n].leaf);
    outdated_[n] |= outdated;
    has_stirred_ = true;
  }
}

/// Computes the boxes of the bodies that have changed since this was called last, by tasks if there are many.
void World::State::find_boxes(const Executor& executor) {
  const std::span<const BodyTree::Leaf> moved = tree_.stale();
  const auto find = [&](std::size_t i) {
    const std::uint32_t n = tree_.item(moved[i]);
    bounds_[n].box = usable_box(*shape_of(bodies_[n]), bodies_[n].motion);
    return true;
  };
  constexpr std::size_t many = 64;
  std::size_t first = 0;
  if (executor.run && executor.threads > 1 && moved.size() >= many) {
    first = for_each_in_chunks(executor, 0, moved.size(), find);
  }
  // The executor may have run no task.
  for (; first < moved.size(); ++first) find(first);
  for (const BodyTree::Leaf leaf : moved) tree_.update(leaf, tree_box(bounds_[tree_.item(leaf)]));
  tree_.refresh();
}

void World::State::collect(double margin, const Executor& executor) {
  if (margin > collected_margin_) {
    for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
      if (!body_ids_.is_used(n)) continue;
      tree_.touch(bodies_[n].leaf);
      outdated_[n] |= outdated;
    }
    collected_margin_ = margin;
  }
  if (tree_.moved().empty() && !has_stale_pairs_ && !has_outdated_planes_) return;
  // If memory runs out here, nothing is lost.
  find_boxes(executor);
  find_fresh_pairs(collected_margin_);
  prepare_merge();
  merge_pairs(margin == collected_margin_);
  note_collected();
}

}  // namespace encage
