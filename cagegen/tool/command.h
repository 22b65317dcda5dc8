// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

namespace encage::tool {

// Exit statuses of every tool of the project (design.md, section 8).
enum Status : int {
  success = 0,
  answer_is_no = 1,  ///< the check failed, the engines disagree
  bad_input = 2,     ///< input or usage; the message is on stderr
  cancelled = 130,   ///< Ctrl-C, by the shells' convention
};

// Each adds one subcommand. Its callback does the work, writes results to
// stdout, sets `status`, and throws encage::Error for bad input (main() prints
// it on stderr and exits with 2).
void add_bake(CLI::App& app, int& status);
void add_check(CLI::App& app, int& status);
void add_info(CLI::App& app, int& status);
void add_export(CLI::App& app, int& status);
void add_render(CLI::App& app, int& status);
void add_query(CLI::App& app, int& status);

}  // namespace encage::tool
