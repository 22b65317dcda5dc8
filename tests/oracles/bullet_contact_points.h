// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

class btCollisionObject;
class btDispatcher;

namespace encage::bullet_bench {

/// User indices of two collision objects, the smaller one first.
using TouchingPair = std::pair<int, int>;

TouchingPair numbers(const btCollisionObject& a, const btCollisionObject& b);

/// A contact point as Bullet stores it, bit for bit.
struct ContactPoint {
  TouchingPair pair;
  std::array<int, 4> features;    ///< part and triangle of either object
  std::array<float, 10> numbers;  ///< local points, normal, distance
  friend bool operator==(const ContactPoint&, const ContactPoint&) = default;
};

/// Returns all contact points, in the order of the dispatcher's manifolds.
std::vector<ContactPoint> contact_points(btDispatcher& dispatcher);

}  // namespace encage::bullet_bench
