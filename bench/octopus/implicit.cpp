// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/implicit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace encage::octopus {

Rod::Rod(const Eigen::Vector3d& start, const Eigen::Vector3d& end, double start_radius, double end_radius)
    : start_(start),
      direction_(Eigen::Vector3d::Zero()),
      middle_((start + end) / 2),
      length_((end - start).norm()),
      start_radius_(start_radius),
      slope_(0),
      lean_(0),
      reach_(length_ / 2 + std::max(start_radius, end_radius)) {
  if (length_ == 0) return;
  direction_ = (end - start) / length_;
  slope_ = (end_radius - start_radius) / length_;
  assert(std::abs(slope_) < 1 && "one sphere would hold the others");
  // Where the derivative of |p - c(t)| - r(t) vanishes.
  lean_ = slope_ / std::sqrt(1 - slope_ * slope_);
}

double Rod::along(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d d = p - start_;
  const double foot = d.dot(direction_);
  const double across = std::sqrt(std::max(0.0, d.squaredNorm() - foot * foot));
  return std::clamp(foot + across * lean_, 0.0, length_);
}

double Rod::value(const Eigen::Vector3d& p) const {
  const double t = along(p);
  return (p - start_ - t * direction_).norm() - (start_radius_ + t * slope_);
}

Sample Rod::sample(const Eigen::Vector3d& p) const {
  const double t = along(p);
  const Eigen::Vector3d d = p - start_ - t * direction_;
  const double distance = d.norm();
  return {distance - (start_radius_ + t * slope_),
          distance > 0 ? Eigen::Vector3d(d / distance) : Eigen::Vector3d::UnitZ()};
}

namespace {

// The rod of a tube with the smallest value at p.
struct NearestRod {
  std::int32_t rod;
  double value;
};

NearestRod nearest_rod(const std::vector<Rod>& rods, const std::vector<std::int32_t>& among, const Eigen::Vector3d& p) {
  // Start with the one whose middle is nearest; it rules out most others by their reach.
  std::int32_t first = among.front();
  double least = std::numeric_limits<double>::infinity();
  for (const std::int32_t rod : among) {
    const double square = (p - rods[rod].middle()).squaredNorm();
    if (square >= least) continue;
    least = square;
    first = rod;
  }
  NearestRod nearest{first, rods[first].value(p)};
  for (const std::int32_t rod : among) {
    const double within = nearest.value + rods[rod].reach();
    if (within < 0 || (p - rods[rod].middle()).squaredNorm() > within * within) continue;
    const double value = rods[rod].value(p);
    if (value < nearest.value) nearest = {rod, value};
  }
  return nearest;
}

// How far two values blend: 0 not at all, 1 fully.
double blend_weight(double low, double high, double width) {
  return width > 0 ? std::max(0.0, 1 - (high - low) / width) : 0;
}

}  // namespace

ImplicitSurface::ImplicitSurface(std::vector<Tube> tubes) : tubes_(std::move(tubes)) {
  for (const Tube& tube : tubes_) widest_blend_ = std::max(widest_blend_, tube.blend);
}

ImplicitSurface::Parts ImplicitSurface::all_parts() const {
  Parts parts;
  for (std::size_t i = 0; i < tubes_.size(); ++i) {
    Parts::Group group{static_cast<std::int32_t>(i), std::vector<std::int32_t>(tubes_[i].rods.size())};
    std::iota(group.rods.begin(), group.rods.end(), 0);
    parts.groups.push_back(std::move(group));
  }
  return parts;
}

ImplicitSurface::Parts ImplicitSurface::relevant(const Parts& parts, const Eigen::Vector3d& centre,
                                                 double radius) const {
  Parts result;
  std::vector<double> tube_distance;
  double least = std::numeric_limits<double>::infinity();
  for (const Parts::Group& group : parts.groups) {
    std::vector<double> distances;
    for (const std::int32_t rod : group.rods) {
      distances.push_back(tubes_[group.tube].rods[rod].value(centre));
    }
    const double nearest = *std::min_element(distances.begin(), distances.end());
    Parts::Group kept{group.tube, {}};
    for (std::size_t i = 0; i < distances.size(); ++i) {
      if (distances[i] <= nearest + 2 * radius) kept.rods.push_back(group.rods[i]);
    }
    result.groups.push_back(std::move(kept));
    tube_distance.push_back(nearest);
    least = std::min(least, nearest);
  }
  // A tube matters if it blends with the nearest one, or with one that does.
  const double reach = least + 2 * radius + 2 * widest_blend_;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tube_distance.size(); ++i) {
    if (tube_distance[i] > reach) continue;
    if (kept != i) result.groups[kept] = std::move(result.groups[i]);
    ++kept;
  }
  result.groups.resize(kept);
  return result;
}

double ImplicitSurface::value(const Eigen::Vector3d& p, const Parts& parts) const {
  double total = std::numeric_limits<double>::infinity();
  for (const Parts::Group& group : parts.groups) {
    const Tube& tube = tubes_[group.tube];
    const double value = nearest_rod(tube.rods, group.rods, p).value;
    const double low = std::min(total, value), high = std::max(total, value);
    const double h = blend_weight(low, high, tube.blend);
    total = low - h * h * tube.blend / 4;  // quadratic smooth minimum
  }
  return total;
}

Sample ImplicitSurface::sample(const Eigen::Vector3d& p, const Parts& parts) const {
  Sample total;
  total.value = std::numeric_limits<double>::infinity();
  for (const Parts::Group& group : parts.groups) {
    const Tube& tube = tubes_[group.tube];
    const Sample nearest = tube.rods[nearest_rod(tube.rods, group.rods, p).rod].sample(p);
    const bool before = total.value < nearest.value;
    Sample low = before ? total : nearest;
    const Sample& high = before ? nearest : total;
    const double h = blend_weight(low.value, high.value, tube.blend);
    low.value -= h * h * tube.blend / 4;
    low.gradient += h / 2 * (high.gradient - low.gradient);
    total = low;
  }
  return total;
}

}  // namespace encage::octopus
