// SPDX-License-Identifier: GPL-3.0-or-later
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/covers/ball_pairs.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once for every instruction set

#include "bench/covers/ball_pairs.h"

#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace encage::covers::HWY_NAMESPACE {

// Loops over lanes are left to the compiler's vectoriser.
constexpr int width = BallNode::width;
using PerBall = std::array<float, width>;

/// The balls of a node where they are at both ends.
struct Moved {
  alignas(32) PerBall centre[2][3];
};

template <int kEnds>
HWY_INLINE void move(const BallNode& node, const BallMaps& maps, Moved& moved) {
  for (int end = 0; end < kEnds; ++end) {
    for (int i = 0; i < 3; ++i) {
      const auto& row = maps.linear[end][i];
      const float offset = maps.offset[end][i];
      for (int k = 0; k < width; ++k) {
        moved.centre[end][i][k] = row[0] * node.x[k] + row[1] * node.y[k] + row[2] * node.z[k] + offset;
      }
    }
  }
}

/// A ball on the way down.
struct Ref {
  float centre[2][3];
  float radius;
  std::int32_t child;
};

template <int kEnds>
HWY_INLINE Ref ref(const BallNode& node, const Moved& moved, int k) {
  Ref result;
  for (int end = 0; end < kEnds; ++end) {
    for (int i = 0; i < 3; ++i) result.centre[end][i] = moved.centre[end][i][k];
  }
  result.radius = node.radius[k];
  result.child = node.child[k];
  return result;
}

/// 1 for each ball that is not proven apart from the other one.
template <int kEnds>
HWY_INLINE void find_near(const BallNode& node, const Moved& moved, const Ref& other, float gap,
                          std::array<std::int32_t, width>& near) {
  for (int k = 0; k < width; ++k) {
    float d[3], square = 0;
    for (int i = 0; i < 3; ++i) d[i] = moved.centre[0][i][k] - other.centre[0][i];
    if (kEnds == 2) {
      float way[3], along = 0, length = 0x1p-100F;
      for (int i = 0; i < 3; ++i) {
        way[i] = (moved.centre[1][i][k] - other.centre[1][i]) - d[i];
        along -= d[i] * way[i];
        length += way[i] * way[i];
      }
      float time = along / length;
      time = time < 0 ? 0 : time;
      time = time > 1 ? 1 : time;
      for (int i = 0; i < 3; ++i) d[i] += time * way[i];
    }
    for (int i = 0; i < 3; ++i) square += d[i] * d[i];
    const float required = node.radius[k] + other.radius + gap;
    near[k] = square > required * required ? 0 : 1;
  }
}

template <int kEnds>
class Traversal {
 public:
  Traversal(const BallCover& a, const BallCover& b, const BallGate& gate) : a_(a), b_(b), gate_(gate) {}

  bool run() {
    const BallNode& root = b_.nodes()[0];
    Moved moved;
    move<kEnds>(root, gate_.b, moved);
    for (int k = 0; k < root.count; ++k) {
      if (!open(a_.nodes()[0], ref<kEnds>(root, moved, k), true)) return false;
    }
    while (size_ > 0) {
      const Pair pair = stack_[--size_];
      const bool open_a =
          pair.b.child == BallNode::last || (pair.a.child != BallNode::last && pair.a.radius >= pair.b.radius);
      const bool apart =
          open_a ? open(a_.nodes()[pair.a.child], pair.b, true) : open(b_.nodes()[pair.b.child], pair.a, false);
      if (!apart) return false;
    }
    return true;
  }

 private:
  struct Pair {
    Ref a, b;
  };
  static constexpr int stack_size = width * (2 * MeshTree::max_depth + 8);

  /// False if there are two last balls near each other.
  HWY_INLINE bool open(const BallNode& node, const Ref& other, bool opens_a) {
    Moved moved;
    move<kEnds>(node, opens_a ? gate_.a : gate_.b, moved);
    std::array<std::int32_t, width> near;
    find_near<kEnds>(node, moved, other, gate_.gap, near);
    for (int k = 0; k < node.count; ++k) {
      if (near[k] == 0) continue;
      if (node.child[k] == BallNode::last && other.child == BallNode::last) return false;
      Pair& pair = stack_[size_++];
      (opens_a ? pair.a : pair.b) = ref<kEnds>(node, moved, k);
      (opens_a ? pair.b : pair.a) = other;
    }
    return true;
  }

  const BallCover& a_;
  const BallCover& b_;
  const BallGate& gate_;
  int size_ = 0;
  std::array<Pair, stack_size> stack_;
};

bool balls_apart(const BallCover& a, const BallCover& b, const BallGate& gate) {
  return gate.ends == 1 ? Traversal<1>(a, b, gate).run() : Traversal<2>(a, b, gate).run();
}

}  // namespace encage::covers::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage::covers {

HWY_EXPORT(balls_apart);

bool balls_apart(const BallCover& a, const BallCover& b, const BallGate& gate) {
  return HWY_DYNAMIC_DISPATCH(balls_apart)(a, b, gate);
}

}  // namespace encage::covers
#endif
