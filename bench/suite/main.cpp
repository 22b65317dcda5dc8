// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench: questions that need no program of their own.

#include "bench/suite/commands.h"

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_commands(
      "encage-bench", "Answers one question with each subcommand, most about the run time, and checks the answers.",
      {assets::command(), distances::command(), handmade::command(), queries::command(), scale::command(),
       threads::command(), twins::command(), zoo::triplets_command()},
      argc, argv);
}
