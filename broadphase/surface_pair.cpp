// SPDX-License-Identifier: Apache-2.0
#include "broadphase/surface_pair.h"

#include "broadphase/triangle_pair.h"

#include <cmath>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

struct CentredBox {
  Vector centre, half;

  explicit CentredBox(const BvhNode& node) {
    for (int k = 0; k < 3; ++k) {
      const double lower = node.lower[k], upper = node.upper[k];
      centre[k] = 0.5 * (lower + upper);
      half[k] = 0.5 * (upper - lower);
    }
  }
};

class PairTest {
 public:
  PairTest(const Surface& a, const Surface& b, const PairFrame& frame, double distance)
      : a_(a), b_(b), frame_(frame), magnitude_(frame.rotation.cwiseAbs()), distance_(distance) {}

  bool apart() const {
    struct Pair {
      std::int32_t a, b;
    };
    // A pair of nodes leaves at most one sibling pair behind per level of either tree.
    std::array<Pair, 2 * Bvh::max_depth + 2> stack;
    int size = 0;
    stack[size++] = {0, 0};
    while (size > 0) {
      const Pair pair = stack[--size];
      const BvhNode& na = a_.nodes[pair.a];
      const BvhNode& nb = b_.nodes[pair.b];
      const CentredBox box_a(na), box_b(nb);
      if (boxes_apart(box_a, box_b)) continue;
      if (na.leaf() && nb.leaf()) {
        if (!leaves_apart(na, nb)) return false;
      } else if (nb.leaf() || (!na.leaf() && box_a.half.squaredNorm() >= box_b.half.squaredNorm())) {
        stack[size++] = {na.first + 1, pair.b};
        stack[size++] = {na.first, pair.b};
      } else {
        stack[size++] = {pair.a, nb.first + 1};
        stack[size++] = {pair.a, nb.first};
      }
    }
    return true;
  }

 private:
  // Separating axes of two oriented boxes (Gottschalk, Lin, Manocha 1996). The
  // products of two edges are not normalised: they are no longer than 1, so that
  // asking for the whole distance is safe, also when they vanish.
  bool boxes_apart(const CentredBox& a, const CentredBox& b) const {
    const Eigen::Matrix3d& r = frame_.rotation;
    const Eigen::Matrix3d& m = magnitude_;
    const Vector t = r * b.centre + frame_.translation - a.centre;
    for (int i = 0; i < 3; ++i) {
      const double reach = a.half[i] + (m(i, 0) * b.half[0] + m(i, 1) * b.half[1] + m(i, 2) * b.half[2]);
      if (std::abs(t[i]) - reach > distance_) return true;
    }
    for (int j = 0; j < 3; ++j) {
      const double reach = (m(0, j) * a.half[0] + m(1, j) * a.half[1] + m(2, j) * a.half[2]) + b.half[j];
      const double offset = t[0] * r(0, j) + t[1] * r(1, j) + t[2] * r(2, j);
      if (std::abs(offset) - reach > distance_) return true;
    }
    for (int i = 0; i < 3; ++i) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
      for (int j = 0; j < 3; ++j) {
        const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        const double reach =
            (a.half[i1] * m(i2, j) + a.half[i2] * m(i1, j)) + (b.half[j1] * m(i, j2) + b.half[j2] * m(i, j1));
        const double offset = t[i2] * r(i1, j) - t[i1] * r(i2, j);
        if (std::abs(offset) - reach > distance_) return true;
      }
    }
    return false;
  }

  bool leaves_apart(const BvhNode& na, const BvhNode& nb) const {
    for (std::int32_t j = nb.first; j < nb.first + nb.count; ++j) {
      const TriangleF& triangle = b_.triangles[j];
      const TriangleD moved = {frame_.map(triangle[0]), frame_.map(triangle[1]), frame_.map(triangle[2])};
      for (std::int32_t i = na.first; i < na.first + na.count; ++i) {
        const TriangleF& still = a_.triangles[i];
        if (!triangles_apart({still[0].cast<double>(), still[1].cast<double>(), still[2].cast<double>()}, moved,
                             distance_)) {
          return false;
        }
      }
    }
    return true;
  }

  const Surface& a_;
  const Surface& b_;
  const PairFrame& frame_;
  Eigen::Matrix3d magnitude_;
  double distance_;
};

}  // namespace

bool surfaces_apart(const Surface& a, const Surface& b, const PairFrame& frame, double distance) noexcept {
  return PairTest(a, b, frame, distance).apart();
}

}  // namespace encage
