// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/flow_options.h"

#include "cagegen/tool/bake_mesh.h"
#include "cagegen/tool/bake_options.h"

#include <encage/error.h>

#include <string>

namespace encage::tool {

namespace {

CLI::Option* add_decimator(CLI::App& app, BakeOptions& options) {
  return app
      .add_option_function<std::string>(
          "--decimator",
          [&options](const std::string& name) {
            options.decimator = name == "regular" ? regular_decimator() : adaptive_decimator();
            options.decimator_name = name;
          },
          "Where the flow's coarse meshes come from: triangles of even size, or small ones where the surface bends; "
          "by default whichever works out better")
      ->check(CLI::IsMember({"regular", "adaptive"}).description(""))
      ->type_name("regular|adaptive");
}

CLI::Option* add_energy(CLI::App& app, const std::string& option, EnergyPtr& energy, const std::string& description) {
  return app
      .add_option_function<std::string>(
          option,
          [option, &energy](const std::string& name) {
            try {
              energy = find_energy(name);
            } catch (const Error& error) {
              throw CLI::ValidationError(option, error.what());
            }
          },
          description)
      ->type_name("start|step|volume|sarap|SUM");
}

}  // namespace

void FlowOptions::add(CLI::App& app, BakeOptions& options, const std::vector<CLI::Option*>& levels) {
  CLI::Option* decimator = add_decimator(app, options);
  CLI::Option* coarse = app.add_option("--coarse", coarse_,
                                       "Meshes for the flow to turn into cages, fine to coarse, separated by commas; "
                                       "closed and free of self-intersection")
                            ->delimiter(',')
                            ->allow_extra_args(false)
                            ->excludes(decimator)
                            ->type_name("FILE,...");
  for (CLI::Option* other : levels) coarse->excludes(other);
  CLI::Option* inflate = add_energy(app, "--energy-inflate", options.energy_inflate,
                                    "What the flow's re-inflation keeps small: displacement from the coarse mesh "
                                    "(start) or per step (default step), the volume, bending and "
                                    "stretching of the surface (sarap), or a sum such as volume+0.1*sarap");
  CLI::Option* final = add_energy(app, "--energy-final", options.energy_final,
                                  "What is minimised after the re-inflation (default volume)");
  CLI::Option* path =
      add_choice(app, "--path", options.path, {{"straight", FlowPath::straight}, {"history", FlowPath::history}},
                 "How the mesh goes back in the re-inflation: straight (default), or along the flow's "
                 "history as in the paper")
          ->type_name("straight|history");
  all_ = {decimator, coarse, inflate, final, path};
}

void FlowOptions::check(const BakeOptions& options) const {
  if (options.method != BakeMethod::collapse) return;
  for (const CLI::Option* option : all_) {
    if (*option) throw Error("--method collapse excludes " + option->get_name() + ", an option of the flow");
  }
}

void FlowOptions::read_coarse(BakeOptions& options, const NoteSink& note) const {
  for (const std::filesystem::path& file : coarse_) {
    options.coarse.push_back(Input(file).mesh(note));
    options.coarse_names.push_back(file.string());
  }
}

}  // namespace encage::tool
