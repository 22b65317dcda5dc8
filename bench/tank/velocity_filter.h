// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/detector.h"
#include "bench/tank/rigid_body.h"

#include <cstdint>
#include <vector>

namespace encage::tank {

struct CpuSeconds {
  double boxes = 0;  ///< world boxes of the motions, and which of them overlap
  double pairs = 0;  ///< candidates and narrow phase
  double walls = 0;
  double integration = 0;  ///< trial poses and impulses
};

struct FilterOptions {
  double dt = 1.0 / 960;
  Eigen::Vector3d gravity = {0, 0, -9.81};
  double restitution = 0.99;
  int most_passes = 8;
  int most_sweeps = 10;
  bool collisions = true;  ///< between bodies
};

/// What one step, or several, came to.
struct FilterReport {
  std::int64_t passes = 0;      ///< detections, the first included
  std::int64_t held = 0;        ///< bodies that had to stay where they were
  std::int64_t conflicts = 0;   ///< contacts of trial motions
  std::int64_t pair_tests = 0;  ///< pairs of bodies handed to the detector
  std::int64_t wall_tests = 0;
  double energy_lost = 0;  ///< by impulses, to restitution
  CpuSeconds cpu;
};

/// Steps copies of one body such that they never interpenetrate: velocity filter, then freeze. Trial motions all start
/// from the poses at hand. Where two collide, impulses change the velocities and the trials are made again, a few
/// times; what still collides then stays where it is for this step. A motion is committed only if it is proven free,
/// the rigid arc included; as the poses at the start of the step are free of intersection, so are those at its end.
class VelocityFilter {
 public:
  /// The detector must outlive this.
  VelocityFilter(const Detector& detector, const MassProperties& mass, std::vector<HalfSpace> walls,
                 const FilterOptions& options);

  /// Moves all bodies by one step. `trials`, if given, receives the motions that were tried first.
  void step(std::vector<BodyState>& bodies, FilterReport& report, std::vector<Motion>* trials = nullptr);

 private:
  struct Trial {
    BodyState start, end;  // `start` takes the impulses
    Motion motion;
    Eigen::AlignedBox3d start_box, end_box, box;  // empty: not known; the motion's
    double arc = 0;
    bool held = false;
    bool changed = true;  // since the last detection
  };
  struct Conflict {
    double time = 0;
    int a = 0, b = 0;  // b: a body, or the number of bodies plus that of the wall
    Eigen::Vector3d normal;
    Eigen::Vector3d local_a, local_b;  // material points that meet, in the frames of the bodies
  };

  void begin(const std::vector<BodyState>& bodies);
  void try_motion(Trial& trial) const;
  void bound(Trial& trial) const;
  void detect(FilterReport& report);
  void detect_walls(FilterReport& report);
  void detect_pairs(FilterReport& report);
  void add(int a, int b, const Contact& contact);
  void resolve(FilterReport& report);
  bool apply(const Conflict& conflict, FilterReport& report);
  void freeze(FilterReport& report);
  void hold(int body, FilterReport& report);
  bool is_wall(const Conflict& conflict) const { return conflict.b >= static_cast<int>(trials_.size()); }

  const Detector& detector_;
  MassProperties mass_;
  std::vector<HalfSpace> walls_;
  FilterOptions options_;
  std::vector<Trial> trials_;
  std::vector<Trial> before_;   // of the step before: their ends are starts now
  std::vector<Conflict> open_;  // found by the last detection of their bodies
  std::vector<Conflict> list_;  // of the step, in the order in which impulses are given
};

}  // namespace encage::tank
