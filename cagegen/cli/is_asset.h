// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace encage::tool {

/// Whether this is a .glb of ours, as opposed to any other file; damaged or not. False if it cannot be read.
bool is_asset(const std::filesystem::path& file);

}  // namespace encage::tool
