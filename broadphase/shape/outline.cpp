// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/shape/outline.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/shape/outline.h"

#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Largest number of lanes; the points are padded to a multiple of it.
constexpr std::size_t block = 8;

void extents(const float* x, const float* y, const float* z, std::size_t count, const float (*rows)[3], float* low,
             float* high) {
  const hn::CappedTag<float, block> d;
  for (int row = 0; row < 3; ++row) {
    const auto rx = hn::Set(d, rows[row][0]), ry = hn::Set(d, rows[row][1]), rz = hn::Set(d, rows[row][2]);
    const auto along = [&](std::size_t i) {
      return hn::Add(hn::Add(hn::Mul(rx, hn::LoadU(d, x + i)), hn::Mul(ry, hn::LoadU(d, y + i))),
                     hn::Mul(rz, hn::LoadU(d, z + i)));
    };
    auto least = along(0), most = least;
    for (std::size_t i = hn::Lanes(d); i < count; i += hn::Lanes(d)) {
      const auto value = along(i);
      least = hn::Min(least, value);
      most = hn::Max(most, value);
    }
    low[row] = hn::GetLane(hn::MinOfLanes(d, least));
    high[row] = hn::GetLane(hn::MaxOfLanes(d, most));
  }
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {

HWY_EXPORT(extents);

Outline::Outline(std::span<const std::array<float, 3>> points) {
  constexpr std::size_t padding = 8;
  const std::size_t count = (points.size() + padding - 1) / padding * padding;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<float, 3>& p = points[i < points.size() ? i : 0];
    x_.push_back(p[0]);
    y_.push_back(p[1]);
    z_.push_back(p[2]);
  }
}

void Outline::extents(const Eigen::Matrix3d& rotation, Eigen::Vector3d& low, Eigen::Vector3d& high) const noexcept {
  float rows[3][3], least[3], most[3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rows[i][j] = static_cast<float>(rotation(i, j));
  }
  HWY_DYNAMIC_DISPATCH(extents)(x_.data(), y_.data(), z_.data(), x_.size(), rows, least, most);
  for (int i = 0; i < 3; ++i) {
    low[i] = static_cast<double>(least[i]);
    high[i] = static_cast<double>(most[i]);
  }
}

}  // namespace encage
#endif
