// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/velocity_filter.h"

#include "bench/common/clock.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <tuple>
#include <utility>

namespace encage::tank {
namespace {

// Relative speed, in units a second, to which impulses separate what would come closer during the step: large against
// rounding, far below anything that matters.
constexpr double separating_speed = 1e-7;

Eigen::Vector3d material_point(const Motion& motion, double time, const Eigen::Vector3d& point) {
  const Eigen::Matrix3d linear = (1 - time) * motion.start.linear() + time * motion.end.linear();
  const Eigen::Vector3d shift = (1 - time) * motion.start.translation() + time * motion.end.translation();
  return linear.inverse() * (point - shift);
}

bool beyond(const Eigen::AlignedBox3d& box, const HalfSpace& wall, double arc) {
  double lowest = 0, size = std::abs(wall.offset);
  for (int k = 0; k < 3; ++k) {
    lowest += std::min(wall.normal[k] * box.min()[k], wall.normal[k] * box.max()[k]);
    size += std::max(std::abs(box.min()[k]), std::abs(box.max()[k]));
  }
  return lowest - wall.offset > arc + 1e-9 * size;  // unit length of the normal within 1e-9
}

}  // namespace

VelocityFilter::VelocityFilter(const Detector& detector, const MassProperties& mass, std::vector<HalfSpace> walls,
                               const FilterOptions& options)
    : detector_(detector), mass_(mass), walls_(std::move(walls)), options_(options) {}

void VelocityFilter::step(std::vector<BodyState>& bodies, FilterReport& report, std::vector<Motion>* trials) {
  {
    const bench::CpuTimer timer(report.cpu.integration);
    begin(bodies);
  }
  if (trials) {
    trials->clear();
    for (const Trial& trial : trials_) trials->push_back(trial.motion);
  }
  for (int pass = 0;; ++pass) {
    detect(report);
    ++report.passes;
    if (open_.empty()) break;
    if (pass == options_.most_passes) {
      freeze(report);
      break;
    }
    resolve(report);
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i] = trials_[i].held ? trials_[i].start : trials_[i].end;
}

void VelocityFilter::begin(const std::vector<BodyState>& bodies) {
  before_.swap(trials_);
  trials_.assign(bodies.size(), {});
  open_.clear();
  list_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    Trial& trial = trials_[i];
    trial.start = bodies[i];
    trial.motion.start = pose(mass_, bodies[i]);
    const bool known = i < before_.size() && before_[i].motion.end.matrix() == trial.motion.start.matrix();
    if (known) trial.start_box = before_[i].end_box;
    try_motion(trial);
  }
}

/// End of a free flight with the velocities as they are now.
void VelocityFilter::try_motion(Trial& trial) const {
  trial.end = free_flight(mass_, trial.start, options_.gravity, options_.dt);
  trial.motion.end = pose(mass_, trial.end);
  trial.changed = true;
}

void VelocityFilter::bound(Trial& trial) const {
  if (trial.start_box.isEmpty()) trial.start_box = detector_.box(trial.motion.start);
  if (trial.held) {
    trial.box = trial.end_box = trial.start_box;
    trial.arc = 0;
    return;
  }
  trial.arc = detector_.arc(trial.motion);
  trial.end_box = detector_.box(trial.motion.end);
  trial.box = trial.start_box.merged(trial.end_box);
  // Rounding of the sums as well: boxes that do not overlap prove that there is no contact.
  const double size = trial.box.min().cwiseAbs().cwiseMax(trial.box.max().cwiseAbs()).maxCoeff();
  const double reach = trial.arc + 4 * std::numeric_limits<double>::epsilon() * size;
  trial.box.min().array() -= reach;
  trial.box.max().array() += reach;
}

/// Brings open_ up to date with the motions that changed and adds what is new to list_.
void VelocityFilter::detect(FilterReport& report) {
  std::erase_if(open_,
                [&](const Conflict& c) { return trials_[c.a].changed || (!is_wall(c) && trials_[c.b].changed); });
  const std::size_t known = open_.size();
  for (std::size_t i = 0; i < trials_.size(); ++i) {
    // No detection answers for half a turn and more.
    if (trials_[i].changed && !is_usable(trials_[i].motion)) hold(static_cast<int>(i), report);
  }
  {
    const bench::CpuTimer timer(report.cpu.boxes);
    for (Trial& trial : trials_) {
      if (trial.changed) bound(trial);
    }
  }
  detect_walls(report);
  if (options_.collisions) detect_pairs(report);
  for (Trial& trial : trials_) trial.changed = false;
  const auto fresh = open_.begin() + static_cast<std::ptrdiff_t>(known);
  std::sort(fresh, open_.end(), [](const Conflict& x, const Conflict& y) {
    return std::tie(x.time, x.a, x.b) < std::tie(y.time, y.a, y.b);
  });
  report.conflicts += open_.end() - fresh;
  list_.insert(list_.end(), fresh, open_.end());
}

void VelocityFilter::detect_walls(FilterReport& report) {
  const bench::CpuTimer timer(report.cpu.walls);
  const int bodies = static_cast<int>(trials_.size());
  for (int i = 0; i < bodies; ++i) {
    const Trial& trial = trials_[i];
    if (!trial.changed || trial.held) continue;
    for (int w = 0; w < static_cast<int>(walls_.size()); ++w) {
      if (beyond(trial.box, walls_[w], trial.arc)) continue;
      ++report.wall_tests;
      const std::optional<Contact> contact = detector_.wall(trial.motion, walls_[w], {.arc = trial.arc});
      if (contact) add(i, bodies + w, *contact);
    }
  }
}

void VelocityFilter::detect_pairs(FilterReport& report) {
  const bench::CpuTimer timer(report.cpu.pairs);
  const int bodies = static_cast<int>(trials_.size());
  for (int i = 0; i < bodies; ++i) {
    for (int j = i + 1; j < bodies; ++j) {
      const Trial &a = trials_[i], &b = trials_[j];
      // Two that are held stand where they stood at the end of the step before: free.
      if ((!a.changed && !b.changed) || (a.held && b.held) || !a.box.intersects(b.box)) continue;
      ++report.pair_tests;
      const std::optional<Contact> contact = detector_.pair(a.motion, b.motion, {.arc = a.arc + b.arc});
      if (contact) add(i, j, *contact);
    }
  }
}

void VelocityFilter::add(int a, int b, const Contact& contact) {
  Conflict conflict{.time = contact.time, .a = a, .b = b, .normal = contact.normal, .local_a = {}, .local_b = {}};
  conflict.local_a = material_point(trials_[a].motion, contact.time, contact.point);
  conflict.local_b = contact.point;
  if (!is_wall(conflict)) conflict.local_b = material_point(trials_[b].motion, contact.time, contact.point);
  open_.push_back(conflict);
}

/// Sweeps over the step's conflicts, there and back, until none asks for an impulse.
void VelocityFilter::resolve(FilterReport& report) {
  const bench::CpuTimer timer(report.cpu.integration);
  bool any = true;
  for (int sweep = 0; any && sweep < options_.most_sweeps; ++sweep) {
    any = false;
    const std::size_t count = list_.size();
    for (std::size_t k = 0; k < count; ++k) any |= apply(list_[sweep % 2 == 0 ? k : count - 1 - k], report);
  }
}

/// One impulse along the normal that reverses the approach, and in any case ends it for this step: the mean velocity
/// over the step knows of gravity and of the rotation's curvature.
bool VelocityFilter::apply(const Conflict& conflict, FilterReport& report) {
  const bool wall = is_wall(conflict);
  Trial& a = trials_[conflict.a];
  Trial* b = wall ? nullptr : &trials_[conflict.b];
  const Eigen::Vector3d point_a = a.motion.start * conflict.local_a;
  Eigen::Vector3d velocity = velocity_at(mass_, a.start, point_a);
  Eigen::Vector3d path = a.motion.end * conflict.local_a - point_a;
  double response = mobility(mass_, a.start, point_a, conflict.normal);
  Eigen::Vector3d point_b = conflict.local_b;
  if (!wall) {
    point_b = b->motion.start * conflict.local_b;
    velocity -= velocity_at(mass_, b->start, point_b);
    path -= b->motion.end * conflict.local_b - point_b;
    response += mobility(mass_, b->start, point_b, conflict.normal);
  }
  const double approach = velocity.dot(conflict.normal), mean = path.dot(conflict.normal) / options_.dt;
  if (approach >= 0 && mean >= 0) return false;
  const double change = std::max(-(1 + options_.restitution) * approach, separating_speed - mean);
  const double impulse = change / response;
  report.energy_lost -= impulse * (approach + change / 2);
  apply_impulse(mass_, a.start, point_a, impulse * conflict.normal);
  try_motion(a);
  if (!wall) {
    apply_impulse(mass_, b->start, point_b, -impulse * conflict.normal);
    try_motion(*b);
  }
  return true;
}

/// Holds the bodies of all conflicts that are left, then those that run into them.
void VelocityFilter::freeze(FilterReport& report) {
  while (!open_.empty()) {
    for (const Conflict& conflict : open_) {
      hold(conflict.a, report);
      if (!is_wall(conflict)) hold(conflict.b, report);
    }
    detect(report);
  }
}

void VelocityFilter::hold(int body, FilterReport& report) {
  Trial& trial = trials_[body];
  if (trial.held) return;
  trial.held = trial.changed = true;
  trial.motion.end = trial.motion.start;
  ++report.held;
}

}  // namespace encage::tank
