// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/stress/quality.h"

#include <encage/bake.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace encage::stress {

/// One bake that asks for much.
struct Job {
  std::string name;   ///< as on the command line; several jobs may share one
  std::string title;  ///< what it is about, for the table's heading
  std::string model;  ///< a file of the folder of meshes without its extension, or empty: `make` needs none
  std::function<TriangleMesh(const TriangleMesh& mesh)> make;  ///< what is baked; empty: the model as it is
  BakeOptions options;
  bool beside_single = false;  ///< compare each layer with a single cage around the layer before
};

struct Layer {
  std::int64_t faces = 0;
  std::string method;                  ///< and what it started from
  std::optional<double> volume_ratio;  ///< to the source's volume
  double excess = 0;                   ///< volume / that of the layer before, less 1; of the first, of the source
  /// The same of a single cage with as many faces around the layer before, baked on its own.
  std::optional<double> single_excess;
  double clearance = 0;  ///< in diagonals of the source
  int genus = 0;
  double seconds = 0;
  Quality quality;
};

struct Outcome {
  std::int64_t input_faces = 0;
  std::vector<Layer> layers;  ///< each certified, or bake() would have thrown
  std::string failure;        ///< why layers are missing; empty if none is
  double cpu_seconds = 0;     ///< of the bake, without the single cages
};

/// Bakes. Pictures of source, section and outermost cage go to `picture`, if it is not empty.
Outcome run(const Job& job, const std::filesystem::path& meshes, int threads, const std::filesystem::path& picture);

}  // namespace encage::stress
