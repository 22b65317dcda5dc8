// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/manifold_reduction.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <tuple>

namespace encage {
namespace {

/// Least cosine of the normals of a patch with that of its first point.
constexpr double patch_cosine = 0.95;
/// Normals a radian apart count as much as points that are this many extents of all contacts apart. Normals that differ
/// hold a body sideways, which points with one normal do not, however far apart they are.
constexpr double normal_weight = 2;
/// A feature of the step before is chosen although it is nearer to others, by this factor of squared distances: solvers
/// come to rest only on points that stay.
constexpr double kept_advantage = 4;
/// The deepest point is that of the step before if it is less deep by this fraction of the margin and the depth.
constexpr double kept_slop = 0.05;
/// Relative error of coordinates.
constexpr double rounding = 1e-12;

class Reduction {
 public:
  Reduction(std::span<const ContactCandidate> candidates, std::span<const std::uint64_t> before,
            std::vector<ReductionEntry>& entries)
      : candidates_(candidates), entries_(entries) {
    entries_.assign(candidates.size(), {});
    double extent = 0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      entries_[i].kept = std::find(before.begin(), before.end(), candidates[i].feature) != before.end();
      entries_[i].spread = std::numeric_limits<double>::infinity();
      extent = std::max(extent, (candidates[i].point_b - candidates[0].point_b).squaredNorm());
      least_ = std::max(least_, rounding * rounding * candidates[i].point_b.squaredNorm());
    }
    scale_ = normal_weight * normal_weight * extent;
  }

  std::size_t deepest(double margin) const {
    const double least = candidates_[0].separation, slop = kept_slop * (margin + std::max(0.0, -least));
    for (std::size_t i = 0; i < candidates_.size() && candidates_[i].separation <= least + slop; ++i) {
      if (entries_[i].kept) return i;
    }
    return 0;
  }

  /// Returns the candidate farthest from all those taken, or none if all are where these are.
  std::size_t take(std::size_t taken) {
    std::size_t next = none;
    double farthest = least_;
    const ContactCandidate& t = candidates_[taken];
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const ContactCandidate& c = candidates_[i];
      entries_[i].spread = std::min(
          entries_[i].spread, (c.point_b - t.point_b).squaredNorm() + scale_ * (c.normal - t.normal).squaredNorm());
      const double far = entries_[i].spread * (entries_[i].kept ? kept_advantage : 1);
      if (far > farthest) {
        farthest = far;
        next = i;
      }
    }
    return next;
  }

  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

 private:
  std::span<const ContactCandidate> candidates_;
  std::vector<ReductionEntry>& entries_;
  double scale_ = 0;
  double least_ = 0;  ///< spread of points that are the same but for rounding
};

/// Numbers patches in the order of their first points.
void group(std::span<ManifoldPoint> points, int most_per_patch) {
  int patches = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].patch = -1;
    for (int patch = 0; patch < patches && points[i].patch < 0; ++patch) {
      const auto in_patch = [&](const ManifoldPoint& other) { return other.patch == patch; };
      const auto earlier = points.first(i);
      const auto first = std::find_if(earlier.begin(), earlier.end(), in_patch);
      const bool full = std::count_if(earlier.begin(), earlier.end(), in_patch) >= most_per_patch;
      if (!full && first->normal.dot(points[i].normal) > patch_cosine) points[i].patch = patch;
    }
    if (points[i].patch < 0) points[i].patch = patches++;
  }
}

}  // namespace

int reduce_contacts(std::vector<ContactCandidate>& candidates, const ManifoldOptions& options,
                    const Eigen::Vector3d& origin, std::span<const std::uint64_t> before,
                    std::vector<ReductionEntry>& entries, std::span<ManifoldPoint> points) {
  if (candidates.empty()) return 0;
  std::sort(candidates.begin(), candidates.end(), [](const ContactCandidate& x, const ContactCandidate& y) {
    return std::tie(x.separation, x.feature) < std::tie(y.separation, y.feature);
  });
  Reduction reduction(candidates, before, entries);
  const int most = std::min(options.most_points, static_cast<int>(points.size()));
  int count = 0;
  for (std::size_t next = reduction.deepest(options.margin); count < most && next != Reduction::none;
       next = reduction.take(next)) {
    const ContactCandidate& c = candidates[next];
    ManifoldPoint& out = points[static_cast<std::size_t>(count++)];
    out.point_a = origin + c.point_a;
    out.point_b = origin + c.point_b;
    out.normal = c.normal;
    out.separation = c.separation;
    out.feature = c.feature;
  }
  // A solver that takes the points in turn gives most of the load to the first ones: the order must not change.
  const auto chosen = points.first(static_cast<std::size_t>(count));
  const auto place = [&](const ManifoldPoint& point) { return std::find(before.begin(), before.end(), point.feature); };
  std::size_t sorted = 1;  // insertion sort: stable, and without memory
  for (; sorted < chosen.size(); ++sorted) {
    for (std::size_t i = sorted; i > 0 && place(chosen[i]) < place(chosen[i - 1]); --i) {
      std::swap(chosen[i], chosen[i - 1]);
    }
  }
  group(chosen, options.most_per_patch);
  return count;
}

}  // namespace encage
