// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/tool/input.h"

#include <encage/bake.h>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <vector>

namespace encage::tool {

/// The options of the flow, apart from the method. Has to outlive the parsing.
class FlowOptions {
 public:
  /// `--decimator`, `--coarse`, `--energy-inflate`, `--energy-final`, `--path`; what is given is set in `options`,
  /// which has to outlive the parsing too. The others are options that `--coarse` stands in for.
  void add(CLI::App& app, BakeOptions& options, const std::vector<CLI::Option*>& levels);

  /// Throws Error for options that the method given cannot use.
  void check(const BakeOptions& options) const;
  const std::vector<std::filesystem::path>& coarse_files() const { return coarse_; }
  /// Reads the coarse meshes. Throws Error naming the file.
  void read_coarse(BakeOptions& options, const NoteSink& note) const;

 private:
  std::vector<std::filesystem::path> coarse_;
  std::vector<CLI::Option*> all_;
};

}  // namespace encage::tool
