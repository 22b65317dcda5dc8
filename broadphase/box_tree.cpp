// SPDX-License-Identifier: Apache-2.0
#include "broadphase/box_tree.h"

#include "broadphase/room.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace encage {
namespace {

using FloatLimits = std::numeric_limits<float>;

/// A float below x. Below by half a unit in the last place at least, which hides the rounding of one double operation.
float below(double x) {
  if (!(x >= -static_cast<double>(FloatLimits::max()))) return -FloatLimits::infinity();
  const float f = static_cast<float>(std::min(x, static_cast<double>(FloatLimits::max())));
  return f - (std::abs(f) * FloatLimits::epsilon() + FloatLimits::min());
}

float above(double x) { return -below(-x); }

/// Half the surface, finite for infinite boxes.
double area(const FloatBox& box) {
  constexpr double largest = FloatLimits::max();
  std::array<double, 3> e;
  for (int k = 0; k < 3; ++k) {
    e[k] = std::clamp(static_cast<double>(box.upper[k]) - static_cast<double>(box.lower[k]), 0.0, largest);
  }
  return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
}

double perimeter(const FloatBox& box) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += static_cast<double>(box.upper[k]) - static_cast<double>(box.lower[k]);
  return sum;
}

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

// ---- Leaves --------------------------------------------------------------

BoxTree::Leaf BoxTree::insert(const FloatBox& box, std::uint32_t item) {
  assert(size_ < std::numeric_limits<std::int32_t>::max() / 2);
  make_room(moved_, static_cast<std::size_t>(size_) + 1);  // update() must not allocate
  make_room(nodes_, nodes_.size() + 2);
  const Leaf leaf = take_node();
  nodes_[leaf].box = box;
  nodes_[leaf].child[0] = static_cast<std::int32_t>(item);
  link(leaf);
  ++size_;
  touch(leaf);
  return leaf;
}

bool BoxTree::update(Leaf leaf, const FloatBox& tight, const FloatBox& fat) noexcept {
  assert(fat.contains(tight));
  const FloatBox& now = nodes_[leaf].box;
  if (now.contains(tight) && !(perimeter(now) > 2 * perimeter(fat))) return false;
  unlink(leaf);
  nodes_[leaf].box = fat;
  link(leaf);
  touch(leaf);
  return true;
}

void BoxTree::remove(Leaf leaf) noexcept {
  unlink(leaf);
  if (const std::int32_t position = nodes_[leaf].child[1]; position != none) {
    moved_[position] = moved_.back();
    nodes_[moved_[position]].child[1] = position;
    moved_.pop_back();
  }
  free_node(leaf);
  --size_;
}

void BoxTree::make_room_for(const BoxTree& other) {
  make_room(nodes_, other.nodes_.size());
  make_room(moved_, static_cast<std::size_t>(other.size_));
}

void BoxTree::touch(Leaf leaf) noexcept {
  if (has_moved(leaf)) return;
  nodes_[leaf].child[1] = static_cast<std::int32_t>(moved_.size());
  moved_.push_back(leaf);
}

void BoxTree::clear_moved() noexcept {
  for (const Leaf leaf : moved_) nodes_[leaf].child[1] = none;
  moved_.clear();
}

// ---- Nodes ---------------------------------------------------------------

std::int32_t BoxTree::take_node() noexcept {
  if (free_ == none) {
    nodes_.emplace_back();  // there is room: insert()
    return static_cast<std::int32_t>(nodes_.size()) - 1;
  }
  const std::int32_t n = free_;
  free_ = nodes_[n].parent;
  nodes_[n] = Node{};
  return n;
}

void BoxTree::free_node(std::int32_t n) noexcept {
  nodes_[n].height = none;
  nodes_[n].parent = free_;
  free_ = n;
}

/// Greedy descent: the cost of a sibling is the area of the new parent and what all ancestors grow by.
std::int32_t BoxTree::best_sibling(const FloatBox& box) const noexcept {
  const double own = area(box);
  std::int32_t n = root_;
  double merged = area(nodes_[n].box.merged(box));
  double growth = 0;  // of the ancestors of n
  std::int32_t best = none;
  double best_cost = std::numeric_limits<double>::infinity();
  while (true) {
    const Node& node = nodes_[n];
    // A higher sibling would leave the new parent out of balance.
    if (node.height <= max_imbalance && (best == none || merged + growth < best_cost)) {
      best = n;
      best_cost = merged + growth;
    }
    if (node.height == 0) return best;
    growth += merged - area(node.box);
    std::array<double, 2> child_merged, bound;
    for (int k = 0; k < 2; ++k) {
      const Node& child = nodes_[node.child[k]];
      child_merged[k] = area(child.box.merged(box));
      // What any place below costs at least.
      bound[k] = child.height == 0 ? child_merged[k] : child_merged[k] - area(child.box) + own;
    }
    const bool lower_is_second = nodes_[node.child[1]].height < nodes_[node.child[0]].height;
    const int k = bound[0] == bound[1] ? (lower_is_second ? 1 : 0) : (bound[1] < bound[0] ? 1 : 0);
    if (best != none && best_cost <= growth + bound[k]) return best;
    n = node.child[k];
    merged = child_merged[k];
  }
}

void BoxTree::link(Leaf leaf) noexcept {
  if (root_ == none) {
    root_ = leaf;
    nodes_[leaf].parent = none;
    return;
  }
  const std::int32_t sibling = best_sibling(nodes_[leaf].box);
  const std::int32_t above_both = nodes_[sibling].parent;
  const std::int32_t parent = take_node();
  nodes_[parent].child = {sibling, leaf};
  replace_child(above_both, sibling, parent);
  nodes_[sibling].parent = nodes_[leaf].parent = parent;
  refit(parent);
  repair_upwards(above_both);
}

void BoxTree::unlink(Leaf leaf) noexcept {
  const std::int32_t parent = nodes_[leaf].parent;
  nodes_[leaf].parent = none;
  if (parent == none) {
    root_ = none;
    return;
  }
  const Node node = nodes_[parent];
  const std::int32_t sibling = node.child[node.child[0] == leaf ? 1 : 0];
  replace_child(node.parent, parent, sibling);
  free_node(parent);
  repair_upwards(node.parent);
}

void BoxTree::replace_child(std::int32_t parent, std::int32_t old_child, std::int32_t new_child) noexcept {
  nodes_[new_child].parent = parent;
  if (parent == none) {
    root_ = new_child;
  } else {
    auto& child = nodes_[parent].child;
    child[child[0] == old_child ? 0 : 1] = new_child;
  }
}

void BoxTree::refit(std::int32_t n) noexcept {
  const Node& a = nodes_[nodes_[n].child[0]];
  const Node& b = nodes_[nodes_[n].child[1]];
  nodes_[n].box = a.box.merged(b.box);
  nodes_[n].height = 1 + std::max(a.height, b.height);
}

void BoxTree::repair_upwards(std::int32_t n) noexcept {
  for (; n != none; n = nodes_[n].parent) {
    const FloatBox old_box = nodes_[n].box;
    const std::int32_t old_height = nodes_[n].height;
    rotate(n);
    if (nodes_[n].box == old_box && nodes_[n].height == old_height) return;
  }
}

/// The cheapest exchange below n after which all heights are in balance and that of n
/// differs from the old one by at most 1: so no ancestor is off by more than what one exchange
/// repairs. Where n itself is out of balance there is one: lifting the higher child of the higher child.
BoxTree::Rotation BoxTree::best_rotation(std::int32_t n, int old_height) const noexcept {
  const auto balanced = [](int a, int b) { return std::abs(a - b) <= max_imbalance; };
  const auto height = [this](std::int32_t m) { return nodes_[m].height; };
  const auto& child = nodes_[n].child;
  Rotation best;
  // Without need, only for a gain.
  best.cost = balanced(height(child[0]), height(child[1])) ? 0 : std::numeric_limits<double>::infinity();
  for (int side = 0; side < 2; ++side) {
    const std::int32_t sinking = child[side];
    const Node& inner = nodes_[child[1 - side]];
    if (inner.height == 0) continue;
    const double inner_area = area(inner.box);
    for (int k = 0; k < 2; ++k) {
      const std::int32_t rising = inner.child[k], staying = inner.child[1 - k];
      const int inner_height = 1 + std::max(height(sinking), height(staying));
      const int new_height = 1 + std::max(height(rising), inner_height);
      if (!balanced(height(sinking), height(staying)) || !balanced(height(rising), inner_height) ||
          std::abs(new_height - old_height) > 1) {
        continue;
      }
      const double cost = area(nodes_[sinking].box.merged(nodes_[staying].box)) - inner_area;
      if (cost < best.cost) best = {sinking, rising, cost};
    }
  }
  return best;
}

void BoxTree::rotate(std::int32_t n) noexcept {
  const Rotation best = best_rotation(n, nodes_[n].height);
  if (best.sinking != none) {
    const std::int32_t inner = nodes_[best.rising].parent;
    replace_child(n, best.sinking, best.rising);
    replace_child(inner, best.rising, best.sinking);
    refit(inner);
  }
  refit(n);
}

double BoxTree::cost() const noexcept {
  double sum = 0;
  for (const Node& node : nodes_) {
    if (node.height >= 0) sum += area(node.box);
  }
  return root_ == none ? 0 : sum / area(nodes_[root_].box);
}

// ---- Check ---------------------------------------------------------------

std::string BoxTree::node_defect(std::int32_t n) const {
  const Node& node = nodes_[n];
  const std::string name = "node " + std::to_string(n) + ": ";
  if (node.height == 0) {
    const std::int32_t position = node.child[1];
    const bool listed =
        position == none || (position < static_cast<std::int32_t>(moved_.size()) && moved_[position] == n);
    return listed ? "" : name + "not among the moved ones";
  }
  const Node& a = nodes_[node.child[0]];
  const Node& b = nodes_[node.child[1]];
  if (a.parent != n || b.parent != n) return name + "a child has another parent";
  if (!(node.box == a.box.merged(b.box))) return name + "not the box of its children";
  if (node.height != 1 + std::max(a.height, b.height)) return name + "wrong height";
  if (std::abs(a.height - b.height) > max_imbalance) return name + "out of balance";
  return "";
}

std::string BoxTree::defect() const {
  if ((root_ == none) != (size_ == 0)) return "wrong root";
  if (root_ != none && nodes_[root_].parent != none) return "the root has a parent";
  if (height() > max_height) return "too high";
  std::vector<std::int32_t> stack;
  if (root_ != none) stack.push_back(root_);
  std::int32_t leaves = 0, visited = 0;
  while (!stack.empty()) {
    const std::int32_t n = stack.back();
    stack.pop_back();
    if (n < 0 || n >= static_cast<std::int32_t>(nodes_.size()) || ++visited > 2 * size_) return "not a tree";
    if (std::string found = node_defect(n); !found.empty()) return found;
    if (nodes_[n].height == 0) {
      ++leaves;
    } else {
      stack.insert(stack.end(), nodes_[n].child.begin(), nodes_[n].child.end());
    }
  }
  if (leaves != size_) return "wrong number of leaves";
  std::int32_t unused = 0;
  for (std::int32_t n = free_; n != none && unused <= static_cast<std::int32_t>(nodes_.size()); n = nodes_[n].parent) {
    ++unused;
  }
  return unused + visited == static_cast<std::int32_t>(nodes_.size()) ? "" : "lost nodes";
}

}  // namespace encage
