// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/error.h>
#include <encage/version.h>

#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "cagegen/tool/command.h"

namespace {

std::string version_text() {
  const encage::Version v = encage::version();
  return "encage " + std::to_string(v.major) + "." + std::to_string(v.minor) + "." + std::to_string(v.patch);
}

int run(int argc, char** argv) {
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

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // exit() prints the help that was asked for, or the mistake.
    return app.exit(error) == 0 ? encage::tool::success : encage::tool::bad_input;
  }
  if (app.get_subcommands().empty()) throw encage::Error("which command? encage --help lists them");
  if (!std::cout.flush()) throw encage::Error("standard output: cannot write");
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const encage::Cancelled&) {
    std::cerr << "encage: cancelled, nothing was written\n";
    return encage::tool::cancelled;
  } catch (const encage::Error& error) {
    std::cerr << "encage: " << error.what() << '\n';
  } catch (const std::bad_alloc&) {
    std::cerr << "encage: out of memory\n";
  } catch (const std::exception& error) {
    std::cerr << "encage: internal error: " << error.what() << '\n';
  }
  return encage::tool::bad_input;
}
