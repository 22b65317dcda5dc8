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

/// Reads a pose file: CSV with the header `step,body,x,y,z,qx,qy,qz,qw` and rows sorted by step, then body, in UTF-8,
/// with a byte order mark or without. Coordinates go up to 1e150, as in queries. Quaternions must be within 1e-6 of
/// unit length and are normalised. Throws Error, which names the file, the line, the value and the reason.
std::vector<PoseStep> read_poses(const std::filesystem::path& file);

/// Writes such a file, whole or not at all. Throws Error, which names the file.
void write_poses(const std::filesystem::path& file, const std::vector<PoseStep>& steps);

}  // namespace encage
