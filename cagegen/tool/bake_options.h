// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <CLI/CLI.hpp>

namespace encage::tool {

// Options that several programs have. `options` has to outlive the parsing.

/// `--faces N,...`, every number at least 4.
CLI::Option* add_faces(CLI::App& app, BakeOptions& options);

/// `--method auto|collapse`.
CLI::Option* add_method(CLI::App& app, BakeOptions& options);

/// `--topology any|keep|simplify`.
CLI::Option* add_topology(CLI::App& app, BakeOptions& options);

/// `--threads N`.
CLI::Option* add_threads(CLI::App& app, BakeOptions& options);

}  // namespace encage::tool
