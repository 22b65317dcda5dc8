// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/cage.h>
#include <encage/error.h>
#include <encage/export.h>

#include <filesystem>

namespace ENCAGE_EXPORT encage {

/// Writes a hierarchy as binary glTF 2.0 with the extension ENCAGE_cages
/// (docs/asset.md), to a temporary in the same folder, then renames it: an
/// existing file is replaced whole or left untouched. The bytes depend on the
/// hierarchy alone. Throws Error.
void write_asset(const std::filesystem::path& file, const CageHierarchy& hierarchy);

/// What a load checks besides the structure, which is always validated.
enum class Verify {
  cages,  ///< hashes of the JSON and of the cage sections
  all,    ///< every byte of the file, the fine level and padding included
};

/// How a file is used.
enum class LoadMode {
  map,   ///< in place: quick, shared with other processes; the file must not be overwritten or truncated meanwhile
  copy,  ///< read into memory: for files that may change
};

/// Loads a hierarchy. Throws Error naming file, section and reason.
CageHierarchy read_asset(const std::filesystem::path& file, Verify verify = Verify::cages);

}  // namespace encage
