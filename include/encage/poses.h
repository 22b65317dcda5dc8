// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/error.h>
#include <encage/export.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace ENCAGE_EXPORT encage {

struct BodyPose {
  std::int32_t body = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/// The bodies present in one step, by increasing body number.
struct PoseStep {
  std::int64_t step = 0;
  std::vector<BodyPose> bodies;
};

/// Reads a pose file: CSV, header `step,body,x,y,z,qx,qy,qz,qw`, rows sorted by
/// step, then body. Quaternions are normalised if within 1e-6 of unit length.
/// Throws Error naming file, line and reason.
std::vector<PoseStep> read_poses(const std::filesystem::path& file);

void write_poses(const std::filesystem::path& file, const std::vector<PoseStep>& steps);

}  // namespace encage
