// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/engine.h"

#include <CGAL/box_intersection_d.h>

namespace encage::scale {
namespace {

/// CGAL's streamed segment trees (Zomorodian and Edelsbrunner 2000).
class Cgal : public BroadPhase {
 public:
  void step(const ScaleFrame& frame, std::vector<PairKey>& pairs) override {
    boxes_.clear();
    for (std::uint32_t n = 0; n < frame.box.size(); ++n) {
      boxes_.emplace_back(frame.box[n].min(), frame.box[n].max(), n);
    }
    CGAL::box_self_intersection_d(boxes_.begin(), boxes_.end(), [&](const NumberedBox& a, const NumberedBox& b) {
      pairs.push_back(pair_key(a.number, b.number));
    });
  }

 private:
  struct NumberedBox : CGAL::Box_intersection_d::Box_d<double, 3, CGAL::Box_intersection_d::ID_NONE> {
    NumberedBox(Eigen::Vector3d low, Eigen::Vector3d high, std::uint32_t n)
        : Box_d(low.data(), high.data()), number(n) {}
    std::uint32_t id() const { return number; }
    std::uint32_t number;
  };
  std::vector<NumberedBox> boxes_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_cgal(const ScaleScene&) { return std::make_unique<Cgal>(); }

}  // namespace encage::scale
