// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <filesystem>

namespace encage::zoo {

/// Writes `prefix`-input.png, `prefix`-section.png (a cut through all levels across the shortest side of the bounds)
/// and `prefix`-cage.png (the outermost cage around the input). The folder must exist. Throws Error.
void write_pictures(const std::filesystem::path& prefix, const SourceMesh& source, const CageHierarchy& hierarchy);

}  // namespace encage::zoo
