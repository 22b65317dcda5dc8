// SPDX-License-Identifier: GPL-3.0-or-later
// encage-stress: bakes what asks for much, and prints layer by layer what came of it.

#include "bench/common/command.h"
#include "bench/common/report.h"
#include "bench/stress/report.h"
#include "bench/stress/runs.h"
#include "cagegen/cli/output_file.h"
#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace encage::stress {

namespace {

constexpr const char* examples = R"(Examples:
  encage-stress build/libcgal-demo/data/meshes --json stress.json --markdown stress.md
      all runs; scripts/unpack-meshes prints the folder
  encage-stress meshes/ --only layers25,noise --pictures out/stress
      some of them, with a section through all layers of each

Exit status: 0 if all layers were made but for those of `pinch`, which is to fail, 1 if not, 2 for bad usage.)";

struct Arguments {
  std::filesystem::path meshes;
  std::vector<std::string> only = job_names();
  int threads = 0;
  std::filesystem::path json, markdown, pictures;
};

void define(bench::CommandOptions& options, Arguments& a) {
  options.add("meshes", a.meshes, "Folder of Debian's libcgal-demo meshes").required().type("DIR");
  options.add("--only", a.only, "Runs, separated by commas").one_of(job_names()).shows_default("all").type("NAME,...");
  options.threads(a.threads, "Threads, 0 for all; the layers do not depend on it");
  options.json(a.json);
  options.add("--markdown", a.markdown, "Write the tables as a Markdown document").type("FILE");
  options.add("--pictures", a.pictures, "Folder (made if missing) for a section through the layers of each run")
      .type("DIR");
}

bool run_all(Arguments& a) {
  bench::check_outputs({a.json, a.markdown}, {});
  if (!a.pictures.empty()) std::filesystem::create_directories(a.pictures);
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  std::string document =
      "# Stress runs\n\nWhat `encage-stress` printed. Every layer is certified. Excess: the volume beyond the layer "
      "before, in\npercent of its volume; *single cage*: that of a cage with as many faces around the layer before, "
      "baked on its own.\nClearance in diagonals. Angles in degrees: the least one, and the one that a twentieth of "
      "the "
      "triangles stay below.\nFolds: edges whose interior angle is below 20 degrees. Seconds of wall clock.\n";
  bool complete = true;
  int number = 0;
  for (const Job& job : all_jobs()) {
    ++number;
    if (std::find(a.only.begin(), a.only.end(), job.name) == a.only.end()) continue;
    const std::filesystem::path picture =
        a.pictures.empty() ? a.pictures : a.pictures / bench::format("%02d-%s.png", number, job.name.c_str());
    const Outcome outcome = run(job, a.meshes, a.threads, picture);
    complete &= outcome.failure.empty() || job.name == "pinch";
    const std::string table = to_markdown(job, outcome);
    std::cout << table << "\n" << std::flush;
    document += "\n" + table;
    runs.push_back(to_json(job, outcome));
  }
  if (!a.json.empty()) tool::write_json(a.json, {{"runs", std::move(runs)}});
  if (!a.markdown.empty()) write_atomically(a.markdown, document);
  return complete;
}

}  // namespace

}  // namespace encage::stress

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_command(
      bench::make_command<stress::Arguments>("encage-stress", "Bakes many layers, noise, soups and the like.",
                                             stress::examples, stress::define, stress::run_all),
      argc, argv);
}
