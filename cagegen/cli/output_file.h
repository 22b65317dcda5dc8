// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>

namespace encage::tool {

/// Throws Error, before any long work, if `file` cannot be written: no such folder, no permission, a folder of that
/// name, or the input itself.
void check_output(const std::filesystem::path& file, const std::filesystem::path& input);

/// Where `encage bake INPUT` alone writes: INPUT's name with .glb in the current folder, or .cages.glb if that is the
/// input itself. Throws Error if a file of that name exists that is no asset of ours.
std::filesystem::path default_asset(const std::filesystem::path& input);

/// Indented, with a newline at the end; atomically.
void write_json(const std::filesystem::path& file, const nlohmann::ordered_json& json);

}  // namespace encage::tool
