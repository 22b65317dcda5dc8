// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>
#include <encage/error.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace encage::tool {

/// A mesh baked, and what is known of its source.
struct BakedMesh {
  std::int64_t input_faces = 0;     ///< triangles as read
  std::int64_t input_vertices = 0;  ///< as read
  SourceMesh source;
  CageHierarchy hierarchy;
  BakeReport report;
};

/// No level at all could be made, although fewer than were asked for would have done.
class NoLevels : public Error {
 public:
  using Error::Error;
};

/// Sanitizes and bakes; `file` is for the messages. Throws Error, NoLevels or Cancelled.
BakedMesh bake_mesh(const std::filesystem::path& file, const TriangleMesh& mesh, const BakeOptions& options,
                    const BakeContext& context);

/// The keys of the asset (cage_json.h), with the seconds of each level, more about the source, `missing_levels` (their
/// faces) and, if what was asked for is not all there, `failure`.
nlohmann::ordered_json to_json(const BakedMesh& baked);

/// What the source is and what sanitizing did, as far as it matters to the user: "closed", "open in 3 places, which are
/// capped; 2 faces without area or twice there". The counts of everything are in the JSON.
std::string describe(const SourceMesh& source);

}  // namespace encage::tool
