// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/cli/program.h"

#include <CLI/CLI.hpp>

namespace encage::tool {

// Each adds one subcommand. Its callback does the work, writes results to stdout, sets `status`, and throws
// encage::Error for bad input (run_program() prints it on stderr and returns 2).
void add_bake(CLI::App& app, int& status);
void add_check(CLI::App& app, int& status);
void add_info(CLI::App& app, int& status);
void add_export(CLI::App& app, int& status);
void add_render(CLI::App& app, int& status);
void add_query(CLI::App& app, int& status);

}  // namespace encage::tool
