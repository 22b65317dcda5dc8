// SPDX-License-Identifier: Apache-2.0
// Which pairs a world keeps: those whose boxes in the tree overlap.
#include "broadphase/body_box.h"
#include "broadphase/room.h"
#include "broadphase/world_state.h"

#include <algorithm>
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

bool World::State::allowed(const Body& a, const Body& b) const noexcept {
  if (a.options.kind != BodyKind::dynamic && b.options.kind != BodyKind::dynamic) return false;
  if (a.options.group != 0 && a.options.group == b.options.group) return a.options.group > 0;
  return masks_allow(a.options.filter, b.options.filter);
}

bool World::State::is_active(std::uint32_t n) const noexcept {
  return bodies_[n].awake || bounds_[n].changed_at > searched_at_;
}

bool World::State::is_active(std::uint64_t key) const noexcept {
  if (is_active(first_of(key))) return true;
  return has_half_space(key) ? planes_[half_space_of(key)].changed_at > searched_at_ : is_active(second_of(key));
}

bool World::State::is_outdated(std::uint64_t key) const noexcept {
  if (outdated_[first_of(key)] != 0) return true;
  return (has_half_space(key) ? outdated_planes_[half_space_of(key)] : outdated_[second_of(key)]) != 0;
}

/// Whether the body of this index is still the one whose pairs are known.
bool World::State::is_same(std::uint32_t n) const noexcept { return body_ids_.contains(collected_[n]); }

bool World::State::is_same(std::uint64_t key) const noexcept {
  if (!is_same(first_of(key))) return false;
  return has_half_space(key) ? plane_ids_.contains(collected_planes_[half_space_of(key)]) : is_same(second_of(key));
}

World::State::Ended World::State::ended(std::uint64_t key) const noexcept {
  const BodyId a = collected_[first_of(key)];
  if (has_half_space(key)) return {key, a, BodyId::none, collected_planes_[half_space_of(key)]};
  return {key, a, collected_[second_of(key)], HalfSpaceId::none};
}

// ---- Pairs that are not known yet ----------------------------------------

void World::State::find_fresh_half_spaces(std::uint32_t n, bool outdated_ones, double margin) {
  const Body& body = bodies_[n];
  if (body.options.kind != BodyKind::dynamic) return;
  const Eigen::AlignedBox3d box = in_double(tree_.box(body.leaf));
  for (std::uint32_t p = 0; p < planes_.size(); ++p) {
    if (!plane_ids_.is_used(p) || (outdated_ones && outdated_planes_[p] == 0)) continue;
    const std::uint64_t key = pair_key(n, half_space_bit | p);
    // The box holds the body's margin already; twice is safe.
    if (masks_allow(body.options.filter, planes_[p].filter) && is_active(key) &&
        !box_beyond(box, planes_[p].half_space, margin + bounds_[n].margin)) {
      scratch_.fresh.push_back(key);
    }
  }
}

void World::State::find_fresh_pairs(double margin) {
  scratch_.fresh.clear();
  tree_.query_moved_pairs(margin * (1 + 1e-12), [&](std::uint32_t a, std::uint32_t b) {
    if (allowed(bodies_[a], bodies_[b]) && (is_active(a) || is_active(b))) scratch_.fresh.push_back(pair_key(a, b));
  });
  for (const BoxTree::Leaf leaf : tree_.moved()) find_fresh_half_spaces(tree_.item(leaf), false, margin);
  if (has_outdated_planes_) {
    for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
      if (outdated_[n] == 0 && body_ids_.is_used(n)) find_fresh_half_spaces(n, true, margin);
    }
  }
  std::sort(scratch_.fresh.begin(), scratch_.fresh.end());
}

// ---- Merging -------------------------------------------------------------

/// Calls visit for each body and half-space whose sleeping pairs are to be looked at.
template <class Visit>
void World::State::for_each_woken(Visit&& visit) const {
  for (const BoxTree::Leaf leaf : tree_.moved()) {
    if (is_active(tree_.item(leaf))) visit(tree_.item(leaf));
  }
  for (const std::uint32_t n : removed_) visit(n);
  if (!has_outdated_planes_) return;
  for (std::uint32_t p = 0; p < planes_.size(); ++p) {
    if (outdated_planes_[p] != 0) visit(half_space_bit | p);
  }
}

/// After this, nothing that merge_pairs() does can throw.
void World::State::prepare_merge() {
  ended_.erase(ended_.begin(), ended_.begin() + static_cast<std::ptrdiff_t>(ended_visited_));
  ended_visited_ = 0;
  std::size_t woken = 0, asleep = 0, ended = 0;
  for_each_woken([&](std::uint32_t owner) { woken += sleeping_.count(owner); });
  for (const Pair& pair : pairs_) {
    if (!pair.candidate) continue;
    const bool same = is_same(pair.key);
    if (same && !is_active(pair.key)) ++asleep;
    if (!same || is_outdated(pair.key)) ++ended;
  }
  make_room(scratch_.woken, woken);
  make_room(scratch_.merged, pairs_.size() + woken + scratch_.fresh.size());
  make_room(ended_, ended_.size() + woken + ended);
  sleeping_.prepare_add(bodies_.size(), planes_.size(), asleep);
}

/// Brings together what was known, of pairs that are awake and of those that wake, with what was found: all sorted.
void World::State::merge_pairs() noexcept {
  std::vector<Pair>& merged = scratch_.merged;
  merged.clear();
  auto fresh = scratch_.fresh.cbegin();
  const auto fresh_end = scratch_.fresh.cend();
  const auto settle = [&](const Pair& known) {
    for (; fresh != fresh_end && *fresh < known.key; ++fresh) merged.push_back({.key = *fresh});
    if (!is_same(known.key)) {
      if (known.candidate) ended_.push_back(ended(known.key));
      return;  // what was found is another pair
    }
    if (!is_active(known.key)) {
      if (known.candidate) sleeping_.add(known.key);
      return;
    }
    const bool found = fresh != fresh_end && *fresh == known.key;
    if (found) ++fresh;
    if (found || !is_outdated(known.key)) {
      merged.push_back(known);
    } else if (known.candidate) {
      ended_.push_back(ended(known.key));
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
  for (; fresh != fresh_end; ++fresh) merged.push_back({.key = *fresh});
  pairs_.swap(merged);
  std::sort(ended_.begin(), ended_.end());
  ++clock_;
}

void World::State::note_collected() noexcept {
  for (const std::uint32_t n : removed_) outdated_[n] = 0;
  removed_.clear();
  for (const BoxTree::Leaf leaf : tree_.moved()) {
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

/// What is left out is looked at once, as if all had changed.
void World::State::stir_sleepers() noexcept {
  searched_at_ = 0;
  left_out_margin_ = std::numeric_limits<double>::infinity();
  for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
    // Pairs of static bodies are found by the other one.
    if (!body_ids_.is_used(n) || bodies_[n].awake || bodies_[n].options.kind == BodyKind::static_) continue;
    tree_.touch(bodies_[n].leaf);
    outdated_[n] |= outdated;
    has_stirred_ = true;
  }
}

void World::State::collect(double margin) {
  if (margin > collected_margin_) {
    for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
      if (!body_ids_.is_used(n)) continue;
      tree_.touch(bodies_[n].leaf);
      outdated_[n] |= outdated;
    }
    collected_margin_ = margin;
  }
  if (tree_.moved().empty() && !has_stale_pairs_ && !has_outdated_planes_) return;
  // Nothing is lost if memory runs out.
  find_fresh_pairs(collected_margin_);
  prepare_merge();
  merge_pairs();
  note_collected();
}

}  // namespace encage
