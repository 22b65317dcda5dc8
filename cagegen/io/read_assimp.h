// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/io/mesh_file.h"

#include <filesystem>
#include <string>
#include <string_view>

// Formats that Encage does not read itself. Assimp reads them in float32 and splits vertices where normals, texture
// coordinates or materials differ; what has equal coordinates is welded again.

namespace encage::io {

/// The formats that Assimp reads and Encage does not: extensions without dots, separated by blanks; empty if this build
/// lacks the library.
std::string assimp_formats();
bool assimp_reads(const std::string& format);

/// Which formats there are beside those that Encage reads itself, or how to get them: for a message.
std::string more_formats();

/// `format` is one of assimp_formats(). Files that the bytes refer to are looked for beside `file`. One thread at a
/// time; others wait.
Soup read_assimp(const std::filesystem::path& file, std::string_view bytes, const std::string& format);

}  // namespace encage::io
