// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/simulate.h"

#include "src/files/hash.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace encage::tank {
namespace {

class Run {
 public:
  Run(const Detector& detector, const MassProperties& mass, const TankOptions& options)
      : detector_(detector),
        mass_(mass),
        options_(options),
        entries_(options, mass_),
        filter_(detector, mass, tank_walls(half_width(options, mass)), filter_options(options)) {
    result_.recording.dt = options.dt;
  }

  void step(std::int64_t number) {
    enter(number);
    scale_velocities(number);
    commit(number);
    std::vector<Motion> trials;
    const FilterReport before = result_.statistics.filter;
    Statistics& s = result_.statistics;
    filter_.step(bodies_, s.filter, &trials);
    s.most_passes = std::max(s.most_passes, s.filter.passes - before.passes);
    s.most_held = std::max(s.most_held, s.filter.held - before.held);
    s.body_steps += static_cast<std::int64_t>(bodies_.size());
    bench::RecordedStep recorded{number, {}};
    for (std::size_t i = 0; i < trials.size(); ++i)
      recorded.bodies.push_back({static_cast<std::int32_t>(i), trials[i]});
    result_.recording.steps.push_back(std::move(recorded));
    s.energy.push_back(energy());
  }

  Simulation finish(std::int64_t steps) {
    commit(steps);
    Statistics& s = result_.statistics;
    const Energy last = energy();
    s.energy_lost = s.filter.energy_lost;
    s.energy_drift = last.kinetic + last.potential - (s.energy_entered + s.energy_added - s.energy_lost);
    result_.trajectory_hash = hash_.digest();
    return std::move(result_);
  }

 private:
  static FilterOptions filter_options(const TankOptions& options) {
    FilterOptions filter;
    filter.dt = options.dt;
    filter.gravity = {0, 0, -options.gravity};
    filter.restitution = options.restitution;
    filter.collisions = options.collisions;
    return filter;
  }

  Energy energy() const {
    Energy sum;
    for (const BodyState& body : bodies_) {
      sum.kinetic += kinetic_energy(mass_, body);
      sum.potential += mass_.mass * options_.gravity * body.centre.z();
    }
    return sum;
  }

  void enter(std::int64_t step) {
    while (static_cast<int>(bodies_.size()) < options_.bodies &&
           entries_.entry_step(static_cast<int>(bodies_.size())) <= step) {
      double top = 0;
      for (const BodyState& body : bodies_) top = std::max(top, body.centre.z() + mass_.radius);
      bodies_.push_back(entries_.next(top));
      result_.statistics.energy_entered += mass_.mass * options_.gravity * bodies_.back().centre.z();
    }
  }

  void scale_velocities(std::int64_t step) {
    if (static_cast<int>(bodies_.size()) < options_.bodies) return;
    const double kinetic = energy().kinetic;
    const double since = static_cast<double>(step - entries_.entry_step(options_.bodies - 1)) * options_.dt;
    const double factor = velocity_factor(options_, mass_, kinetic / options_.bodies, since);
    if (factor == 1) return;
    for (BodyState& body : bodies_) {
      body.velocity *= factor;
      body.angular_momentum *= factor;
    }
    result_.statistics.energy_added += energy().kinetic - kinetic;
  }

  void commit(std::int64_t number) {
    PoseStep step{number, {}};
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      step.bodies.push_back({static_cast<std::int32_t>(i), pose(mass_, bodies_[i])});
      std::array<double, 12> values;
      for (int k = 0; k < 12; ++k) values[k] = step.bodies.back().pose.matrix()(k % 3, k / 3);
      hash_.add(std::as_bytes(std::span(values)));
    }
    result_.poses.push_back(std::move(step));
  }

  const Detector& detector_;
  const MassProperties& mass_;
  const TankOptions& options_;
  Entries entries_;
  VelocityFilter filter_;
  std::vector<BodyState> bodies_;
  Hasher hash_;
  Simulation result_;
};

}  // namespace

Simulation simulate(const ShapePtr& shape, const MassProperties& mass, const TankOptions& options,
                    const SimulationContext& context) {
  return simulate(ShapeDetector(shape, mass.centre), mass, options, context);
}

Simulation simulate(const Detector& detector, const MassProperties& mass, const TankOptions& options,
                    const SimulationContext& context) {
  validate(options, mass);
  const std::int64_t steps = std::llround(options.seconds / options.dt);
  Run run(detector, mass, options);
  for (std::int64_t step = 0; step < steps; ++step) {
    if (context.cancel && *context.cancel) throw Cancelled();
    run.step(step);
    if (context.progress) context.progress(static_cast<double>(step + 1) / static_cast<double>(steps));
  }
  return run.finish(steps);
}

}  // namespace encage::tank
