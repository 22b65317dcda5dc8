// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
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
  };
  std::filesystem::path file;
  Outcome outcome = Outcome::failed;
  std::string error;
  /// If baked: the keys of `encage bake --json`, and `clean`.
  nlohmann::ordered_json figures;

  bool clean() const { return outcome == Outcome::baked && figures.at("clean").get<bool>(); }
  bool certified() const;
  double cpu_seconds() const { return figures.at("cpu_seconds").get<double>(); }
};

/// Mesh files by extension, those of a folder (recursively) sorted by name.
/// Throws Error for a path that does not exist.
std::vector<std::filesystem::path> mesh_files(const std::vector<std::filesystem::path>& paths);

/// Bakes one file in a child process; `gallery` (may be empty) is the folder for pictures.
Model bake_model(const std::filesystem::path& file, const BakeOptions& options, const std::filesystem::path& gallery);

/// The level that stands for a target of BakeOptions::faces, as its figures;
/// null if that level was skipped because the input is small.
nlohmann::ordered_json level_for(const Model& model, const std::vector<std::int64_t>& faces, std::size_t target);

}  // namespace encage::zoo
