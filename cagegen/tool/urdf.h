// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace encage::tool {

/// One collision mesh of a link, as a robot description (URDF) names it.
struct UrdfMesh {
  std::string link;
  std::string body;            ///< unique: the link's name, and a number if the link has several
  std::string name;            ///< as written, e.g. "package://arm/meshes/hand.stl"
  std::filesystem::path file;  ///< where it was found
  Eigen::Vector3d scale;       ///< of the mesh's axes; no factor is 0
  Eigen::Vector3d origin_xyz;  ///< where the link has the mesh; not applied to it
  Eigen::Vector3d origin_rpy;
};

struct Urdf {
  std::string name;                ///< of the robot
  std::vector<UrdfMesh> meshes;    ///< in the order of the file
  std::vector<std::string> notes;  ///< what is skipped
};

/// Whether this build has the XML library.
bool has_urdf() noexcept;

/// Reads a robot description. `file` stands for it in messages, and its folder is where meshes are looked for: relative
/// names in it, package:// and model:// in it and in the folders above it. Throws Error naming the link and the reason.
Urdf read_urdf(const std::filesystem::path& file, std::string_view bytes);

}  // namespace encage::tool
