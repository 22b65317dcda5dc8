// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace encage {

/// Throws Error for values out of range and for options that contradict each other.
void validate(const BakeOptions& options);

/// Triangles of each level, fine to coarse. A closed surface gets no more than it has itself, which is as tight as a
/// cage of it can be. Levels that are not coarser than the one before are left out, and `log` says so; coarse meshes
/// made by the user are all kept.
std::vector<std::int64_t> level_faces(const BakeOptions& options, const SourceMesh& source,
                                      const std::function<void(std::string_view)>& log);

/// What the asset records. Options of the flow are named only where it may run.
std::string options_json(const BakeOptions& options, const std::vector<std::int64_t>& faces);

}  // namespace encage
