// SPDX-License-Identifier: Apache-2.0
#pragma once

// The motion of a body during a step, and half-spaces.

#include <encage/export.h>

#include <Eigen/Geometry>

#include <string>

namespace ENCAGE_EXPORT encage {

/// Rigid motion from the body frame (the frame of the source file) to the world, of a body at `scale` times its size:
/// x -> pose * (scale * x). Every vertex moves on the straight line between its two positions. Queries get slow where
/// the rotation exceeds 120 degrees.
///
/// *What two poses tell.* They tell where the body is at both ends, and nothing of the way between: neither the arcs of
/// its points, which arc_margin() bounds, nor how often it turns. 190 degrees and -170 have the same poses, and so have
/// a full turn and rest: queries take the short way. split_motion() makes motions of velocities, for any rotation.
///
/// *Poses in float* are not rigid enough (is_usable()); nearest_rigid() and pose_from() correct them.
struct Motion {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d end = Eigen::Isometry3d::Identity();
  double scale = 1;  ///< > 0, usually 1; the same during the whole motion

  static Motion resting(const Eigen::Isometry3d& pose, double scale = 1) { return {pose, pose, scale}; }
  bool at_rest() const { return start.matrix() == end.matrix(); }
};

/// Returns true if queries accept the motion: both poses are finite, do not mirror and are within 1e-9 of rigid; the
/// rotation between them, taken the short way, is below 180 degrees (with 1e-6 to spare); the scale is between 1e-50
/// and 1e50.
bool is_usable(const Motion& motion) noexcept;

/// Returns why queries do not accept the motion, and what helps, e.g. "the end pose mirrors the body"; empty if they
/// do.
std::string motion_defect(const Motion& motion);

/// The solid { x : normal . x <= offset } of the world; the normal has length 1 within 1e-9, `offset` is in world
/// units.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;
};

}  // namespace encage
