// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/cage.h>
#include <encage/shape.h>

#include <filesystem>

namespace encage::bench {

/// A mesh of an asset, whose vertices count from `origin`, in the body frame.
TriangleMesh in_body_frame(const TriangleMesh& mesh, const Eigen::Vector3d& origin);

/// The shape's fine mesh in the body frame. Throws Error that names `file` if there is none.
TriangleMesh fine_mesh(const Shape& shape, const std::filesystem::path& file);

}  // namespace encage::bench
