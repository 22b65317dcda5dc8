// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench: questions about the run time that need no program of their own.

#include "bench/suite/commands.h"

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_commands("encage-bench",
                             "Measures the run time, each subcommand under one aspect, and checks its answers.",
                             {assets::command(), distances::command(), scale::command(), threads::command(),
                              twins::command(), zoo::triplets_command()},
                             argc, argv);
}
