// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/cage.h>
#include <encage/error.h>
#include <encage/export.h>
#include <encage/mesh.h>

#include <filesystem>

namespace ENCAGE_EXPORT encage {

/// Writes a hierarchy as binary glTF 2.0 with the extension ENCAGE_cages (docs/asset.md). It writes a temporary file in
/// the same folder and renames it, so that an existing file is replaced whole or left untouched. The bytes depend only
/// on the hierarchy and the version of the library. Throws Error, which names the file.
void write_asset(const std::filesystem::path& file, const CageHierarchy& hierarchy);

/// What a load verifies by hashes. It validates the structure in any case.
enum class Verify {
  cages,  ///< the JSON and the cages; quick, the usual choice
  all,    ///< every byte of the file, the fine mesh and padding included
};

/// How a file is used.
enum class LoadMode {
  map,   ///< in place: quick, and shared by processes; the file must not be overwritten or truncated meanwhile
  copy,  ///< from memory: for files that may change
};

/// Loads a hierarchy. Throws Error, which names the file, the section and the reason.
CageHierarchy read_asset(const std::filesystem::path& file, Verify verify = Verify::cages);

/// Checks that an asset was baked from this mesh: the source's hash is the mesh's, or, for a mesh that was rounded to
/// float or whose vertices were split or welded since, every triangle of the stored fine mesh is the mesh's triangle of
/// the same number. Linear time. Throws Error, which names the file and how the mesh differs.
void require_source(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace encage
