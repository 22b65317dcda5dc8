// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include <functional>

namespace encage::tool {

// Exit statuses of every program of the project.
enum Status : int {
  success = 0,
  answer_is_no = 1,  ///< the check failed, the engines disagree
  bad_input = 2,     ///< input or usage; the message is on stderr
  cancelled = 130,   ///< Ctrl-C, by the shells' convention
};

/// What main() of every tool does: parses the command line, calls `run`, writes what is left of stdout, and returns the
/// exit status: what `run` returned, or what became of an exception, whose message goes to stderr after the name of
/// `app`. Help that was asked for is printed instead of running.
int run_program(CLI::App& app, int argc, char** argv, const std::function<int()>& run);

}  // namespace encage::tool
