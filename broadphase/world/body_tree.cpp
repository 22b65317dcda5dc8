// SPDX-License-Identifier: Apache-2.0
#include "broadphase/world/body_tree.h"

#include "broadphase/world/room.h"

#include <algorithm>
#include <cmath>

namespace encage {
namespace {

using FloatLimits = std::numeric_limits<float>;

/// Returns a float below x by at least half a unit in the last place, which covers the rounding of one double
/// operation.
float below(double x) {
  if (!(x >= -static_cast<double>(FloatLimits::max()))) return -FloatLimits::infinity();
  const float f = static_cast<float>(std::min(x, static_cast<double>(FloatLimits::max())));
  return f - (std::abs(f) * FloatLimits::epsilon() + FloatLimits::min());
}

float above(double x) { return -below(-x); }

std::size_t nodes_for(std::size_t lanes) { return (lanes + BoxLanes::width - 1) / BoxLanes::width; }

}  // namespace

FloatBox FloatBox::around(const Eigen::AlignedBox3d& box, double margin) noexcept {
  FloatBox result;
  for (int k = 0; k < 3; ++k) {
    result.lower[k] = below(box.min()[k] - margin);
    result.upper[k] = above(box.max()[k] + margin);
  }
  return result;
}

FloatBox FloatBox::merged(const FloatBox& other) const noexcept {
  FloatBox result;
  for (int k = 0; k < 3; ++k) {
    result.lower[k] = std::min(lower[k], other.lower[k]);
    result.upper[k] = std::max(upper[k], other.upper[k]);
  }
  return result;
}

FloatBox FloatBox::enlarged(double margin) const noexcept {
  FloatBox result;
  for (int k = 0; k < 3; ++k) {
    result.lower[k] = below(static_cast<double>(lower[k]) - margin);
    result.upper[k] = above(static_cast<double>(upper[k]) + margin);
  }
  return result;
}

FloatBox BoxLanes::empty_box() noexcept {
  FloatBox box;
  box.lower.fill(FloatLimits::quiet_NaN());
  box.upper.fill(FloatLimits::quiet_NaN());
  return box;
}

BoxLanes::BoxLanes() noexcept {
  for (int lane = 0; lane < width; ++lane) clear(lane);
}

FloatBox BoxLanes::merged() const noexcept {
  FloatBox result;
  result.lower.fill(FloatLimits::infinity());
  result.upper.fill(-FloatLimits::infinity());
  for (int k = 0; k < 3; ++k) {
    for (int lane = 0; lane < width; ++lane) {
      // The order of the arguments makes std::min ignore NaN.
      result.lower[k] = std::min(result.lower[k], lower[k][lane]);
      result.upper[k] = std::max(result.upper[k], upper[k][lane]);
    }
  }
  return result;
}

// ---- Leaves --------------------------------------------------------------

BodyTree::Leaf BodyTree::insert(const FloatBox& box, std::uint32_t item) {
  assert(size_ < std::numeric_limits<std::int32_t>::max() / 2);
  // No other function may allocate.
  make_room(leaves_, leaves_.size() + 1);
  make_room_for(order_.size() + 1, static_cast<std::size_t>(size_) + 1);
  Leaf leaf = free_;
  if (leaf == none) {
    leaf = static_cast<Leaf>(leaves_.size());
    leaves_.emplace_back();
  } else {
    free_ = leaves_[leaf].slot;
  }
  leaves_[leaf] = {box, item, slots(), none};
  order_.push_back(leaf);
  items_.push_back(item);
  ++size_;
  ++loose_;
  touch(leaf);
  return leaf;
}

void BodyTree::update(Leaf leaf, const FloatBox& box) noexcept {
  leaves_[leaf].box = box;
  touch(leaf);
}

void BodyTree::make_room_for(const BodyTree& other) {
  make_room(leaves_, other.leaves_.size());
  make_room_for(other.order_.size(), static_cast<std::size_t>(other.size_));
}

void BodyTree::make_room_for(std::size_t slots, std::size_t leaves) {
  make_room(moved_, leaves);
  make_room(centres_, leaves);
  make_room(order_, slots);
  make_room(items_, slots);
  std::size_t nodes = nodes_for(slots);
  make_room(moved_lanes_, nodes);
  for (int k = 0; k < most_levels && nodes > 0; ++k, nodes = nodes > 1 ? nodes_for(nodes) : 0) {
    make_room(levels_[k], nodes);
    make_room(dirty_[k], nodes);
  }
}

/// The nodes above keep their boxes, which are still correct but may be larger than necessary.
void BodyTree::remove(Leaf leaf) noexcept {
  Entry& entry = leaves_[leaf];
  if (entry.moved != none) {
    make_stale(leaf);
    moved_[entry.moved] = moved_.back();
    leaves_[moved_[entry.moved]].moved = entry.moved;
    moved_.pop_back();
  }
  const std::int32_t node = entry.slot / BoxLanes::width, lane = entry.slot % BoxLanes::width;
  order_[entry.slot] = none;
  if (node < static_cast<std::int32_t>(moved_lanes_.size())) {
    levels_[0][node].clear(lane);
    moved_lanes_[node] &= static_cast<std::uint8_t>(~(1u << lane));
  }
  entry = {};
  entry.slot = free_;
  free_ = leaf;
  --size_;
}

void BodyTree::touch(Leaf leaf) noexcept {
  fresh_ = false;
  if (has_moved(leaf)) return make_stale(leaf);
  leaves_[leaf].moved = static_cast<std::int32_t>(moved_.size());
  moved_.push_back(leaf);
}

/// Takes a moved leaf out of those that the nodes know.
void BodyTree::make_stale(Leaf leaf) noexcept {
  const std::int32_t place = leaves_[leaf].moved;
  if (place >= placed_) return;
  const Leaf last = moved_[--placed_];
  moved_[place] = last;
  leaves_[last].moved = place;
  moved_[placed_] = leaf;
  leaves_[leaf].moved = placed_;
}

void BodyTree::clear_moved() noexcept {
  if (!fresh_) refresh();
  for (const Leaf leaf : moved_) {
    leaves_[leaf].moved = none;
    moved_lanes_[leaves_[leaf].slot / BoxLanes::width] = 0;
  }
  moved_.clear();
  placed_ = 0;
}

// ---- Nodes ---------------------------------------------------------------

void BodyTree::refresh() noexcept {
  if (fresh_) return;
  const bool worn = is_worn();
  if (worn) order_leaves();
  resize_levels();
  place_leaves(worn || 4 * stale().size() > order_.size());
  refit();
  placed_ = static_cast<std::int32_t>(moved_.size());
  fresh_ = true;
}

bool BodyTree::is_worn() const noexcept {
  // Approximate cost of ordering a leaf, in units of work.
  constexpr double ordering = 4;
  return loose_ > 8 + size_ / 32 || slots() > 2 * size_ + 64 || lost_ > ordering * size_;
}

void BodyTree::order_leaves() noexcept {
  // The limit gives infinite boxes a finite centre as well.
  constexpr float largest = FloatLimits::max() / 4;
  centres_.clear();
  for (const Leaf leaf : order_) {
    if (leaf == none) continue;
    Centre& centre = centres_.emplace_back();
    centre.leaf = leaf;
    const FloatBox& box = leaves_[leaf].box;
    for (int k = 0; k < 3; ++k) {
      centre.at[k] = std::clamp(box.lower[k], -largest, largest) + std::clamp(box.upper[k], -largest, largest);
    }
  }
  split(0, centres_.size());
  order_.resize(centres_.size());
  items_.resize(centres_.size());
  for (std::size_t slot = 0; slot < centres_.size(); ++slot) {
    order_[slot] = centres_[slot].leaf;
    items_[slot] = item(centres_[slot].leaf);
    leaves_[centres_[slot].leaf].slot = static_cast<std::int32_t>(slot);
  }
  for (int k = 0; k < height_; ++k) {
    levels_[k].clear();
    dirty_[k].clear();
  }
  moved_lanes_.clear();
  loose_ = 0;
  lost_ = 0;
  least_rate_ = infinite;
}

/// Splits the leaves into halves that fill whole nodes, along the coordinate in which centres differ most.
void BodyTree::split(std::size_t first, std::size_t last) noexcept {
  while (last - first > BoxLanes::width) {
    std::array<float, 3> low = centres_[first].at, high = low;
    for (std::size_t i = first + 1; i < last; ++i) {
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], centres_[i].at[k]);
        high[k] = std::max(high[k], centres_[i].at[k]);
      }
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    }
    const std::size_t middle = first + std::bit_floor(last - first - 1);
    const auto begin = centres_.begin();
    std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
                     begin + static_cast<std::ptrdiff_t>(last),
                     [axis](const Centre& a, const Centre& b) { return a.at[axis] < b.at[axis]; });
    split(middle, last);
    last = middle;
  }
}

/// New nodes are dirty.
void BodyTree::resize_levels() noexcept {
  std::size_t nodes = nodes_for(order_.size());
  moved_lanes_.resize(nodes);
  const int old_height = height_;
  for (height_ = 0; height_ < most_levels && nodes > 0; nodes = nodes_for(nodes)) {
    levels_[height_].resize(nodes);
    dirty_[height_].resize(nodes, 1);
    ++height_;
    if (nodes == 1) break;
  }
  if (height_ == old_height) return;
  for (int k = height_; k < old_height; ++k) {
    levels_[k].clear();
    dirty_[k].clear();
  }
  // All nodes have to enter their boxes in the nodes that are above them now.
  for (int k = 0; k < height_; ++k) std::fill(dirty_[k].begin(), dirty_[k].end(), std::uint8_t{1});
}

/// Places the leaves that are stale, or all of them; all are placed in order of slots, which uses the caches well.
void BodyTree::place_leaves(bool all) noexcept {
  const auto place = [this](Leaf leaf, std::int32_t slot) {
    const std::int32_t node = slot / BoxLanes::width, lane = slot % BoxLanes::width;
    levels_[0][node].set(lane, leaves_[leaf].box);
    dirty_[0][node] = 1;
    if (has_moved(leaf)) moved_lanes_[node] |= static_cast<std::uint8_t>(1u << lane);
  };
  if (!all) {
    for (const Leaf leaf : stale()) place(leaf, leaves_[leaf].slot);
    return;
  }
  for (std::int32_t slot = 0; slot < slots(); ++slot) {
    if (order_[slot] != none) place(order_[slot], slot);
  }
}

void BodyTree::refit() noexcept {
  for (int k = 0; k < height_; ++k) {
    for (std::size_t n = 0; n < dirty_[k].size(); ++n) {
      if (dirty_[k][n] == 0) continue;
      dirty_[k][n] = 0;
      if (k + 1 == height_) continue;
      levels_[k + 1][n / BoxLanes::width].set(static_cast<int>(n % BoxLanes::width), levels_[k][n].merged());
      dirty_[k + 1][n / BoxLanes::width] = 1;
    }
  }
}

/// Counts the time that searches lose because they test more nodes than they did just after leaves were ordered.
void BodyTree::account(std::int64_t nodes) noexcept {
  if (nodes == 0) return;
  const double rate = static_cast<double>(work_) / static_cast<double>(nodes);
  least_rate_ = std::min(least_rate_, rate);
  lost_ += static_cast<double>(work_) - least_rate_ * static_cast<double>(nodes);
}

// ---- Check ---------------------------------------------------------------

std::string BodyTree::defect() const {
  std::int32_t used = 0, moved = 0;
  for (std::int32_t slot = 0; slot < slots(); ++slot) {
    const Leaf leaf = order_[slot];
    if (leaf == none) continue;
    const std::string name = "leaf " + std::to_string(leaf) + ": ";
    ++used;
    if (leaves_[leaf].slot != slot) return name + "in another slot";
    if (items_[slot] != item(leaf)) return name + "another item than in its slot";
    if (!has_moved(leaf)) continue;
    ++moved;
    if (moved_[leaves_[leaf].moved] != leaf) return name + "not among the moved ones";
    if (is_stale(leaf)) continue;
    if (!(levels_[0][slot / BoxLanes::width].at(slot % BoxLanes::width) == box(leaf))) return name + "known elsewhere";
  }
  if (used != size_) return "wrong number of leaves";
  if (moved != static_cast<std::int32_t>(moved_.size())) return "wrong number of moved leaves";
  std::int32_t unused = 0;
  for (Leaf leaf = free_; leaf != none && unused <= static_cast<Leaf>(leaves_.size()); leaf = leaves_[leaf].slot) {
    ++unused;
  }
  if (unused + used != static_cast<std::int32_t>(leaves_.size())) return "lost leaves";
  if (!fresh_) return "";
  if (!stale().empty()) return "stale leaves after a refresh";
  for (std::int32_t slot = 0; slot < slots(); ++slot) {
    const Leaf leaf = order_[slot];
    const std::int32_t node = slot / BoxLanes::width, lane = slot % BoxLanes::width;
    if (leaf != none && !(levels_[0][node].at(lane) == box(leaf))) return "a leaf has another box than its slot";
    const bool marked = (moved_lanes_[node] >> lane & 1) != 0;
    if (marked != (leaf != none && has_moved(leaf))) return "a slot does not know whether its leaf has moved";
  }
  for (int k = 0; k + 1 < height_; ++k) {
    if (levels_[k + 1].size() != nodes_for(levels_[k].size())) return "wrong number of nodes";
    for (std::size_t n = 0; n < levels_[k].size(); ++n) {
      const FloatBox above = levels_[k + 1][n / BoxLanes::width].at(static_cast<int>(n % BoxLanes::width));
      if (!(above == above.merged(levels_[k][n].merged()))) return "a node is larger than its parent knows";
    }
  }
  return "";
}

}  // namespace encage
