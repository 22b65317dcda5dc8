// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/command.h"

#include <encage/error.h>
#include <encage/version.h>

#include <string>

namespace {

std::string version_text() {
  const encage::Version v = encage::version();
  return "encage " + std::to_string(v.major) + "." + std::to_string(v.minor) + "." + std::to_string(v.patch);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Certified nested cages around triangle meshes, for fast collision rejection.", "encage");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(0, 1);  // an unknown word is then reported as such
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return std::string("encage: ") + error.what() + "\nencage --help and encage COMMAND --help say more.\n";
  });

  int status = encage::tool::success;
  encage::tool::add_bake(app, status);
  encage::tool::add_check(app, status);
  encage::tool::add_info(app, status);
  encage::tool::add_export(app, status);
  encage::tool::add_render(app, status);
  encage::tool::add_query(app, status);

  // Commands work while the line is parsed.
  return encage::tool::run_program(app, argc, argv, [&] {
    if (app.get_subcommands().empty()) throw encage::Error("which command? encage --help lists them");
    return status;
  });
}
