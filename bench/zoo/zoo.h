// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/zoo/baselines.h"

#include <encage/bake.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace encage::zoo {

/// What came of one file.
struct Model {
  enum class Outcome {
    baked,
    no_mesh,  ///< refused by the reader, e.g. a point set; `error` says why
    failed,   ///< a mesh without cages; `error` says why
    skipped,  ///< a mesh that a baseline was not tried on
  };
  std::filesystem::path file;
  Outcome outcome = Outcome::failed;
  std::string error;
  /// If baked: the keys of `encage bake --json`, and `clean`. Of a baseline fewer keys, and levels that may be null,
  /// uncertified or without a volume ratio.
  nlohmann::ordered_json figures;

  bool clean() const { return outcome == Outcome::baked && figures.at("clean").get<bool>(); }
  bool certified() const;
  double cpu_seconds() const { return figures.at("cpu_seconds").get<double>(); }
};

/// Mesh files by extension, those of a folder (recursively) sorted by name. Throws Error for a path that does not
/// exist.
std::vector<std::filesystem::path> mesh_files(const std::vector<std::filesystem::path>& paths);

/// Bakes one file in a child process; `gallery` (may be empty) is the folder for pictures.
Model bake_model(const std::filesystem::path& file, const BakeOptions& options, const std::filesystem::path& gallery);

/// One baseline on the mesh of a model that was baked, once for each of `faces` that is less than the mesh has, around
/// the mesh itself. In a child process. Skipped if the mesh is not clean, or too small for all of `faces`. Per level:
/// `hits`, `self_hits`, `cpu_seconds` and `error` of BaselineResult.
Model run_baseline(const PlainMethod& baseline, const Model& known, const std::vector<std::int64_t>& faces);

/// The level that stands for a target of BakeOptions::faces, as its figures; null if that level was skipped because the
/// input is small.
nlohmann::ordered_json level_for(const Model& model, const std::vector<std::int64_t>& faces, std::size_t target);

}  // namespace encage::zoo
