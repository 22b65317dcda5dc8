// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/bake_options.h"

#include <cstdint>
#include <limits>
#include <string>

namespace encage::tool {

CLI::Option* add_faces(CLI::App& app, BakeOptions& options) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  return app.add_option("--faces", options.faces, "Triangles per level, fine to coarse, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(std::int64_t{4}, most).description(""))
      ->type_name("N,...")
      ->allow_extra_args(false);
}

const std::map<std::string, BakeMethod>& method_names() {
  static const std::map<std::string, BakeMethod> names = {
      {"auto", BakeMethod::automatic}, {"flow", BakeMethod::flow}, {"collapse", BakeMethod::collapse}};
  return names;
}

CLI::Option* add_method(CLI::App& app, BakeOptions& options) {
  return add_choice(app, "--method", options.method, method_names(),
                    "How cages are made: flow and re-inflation, conservative collapse, or auto (default), which "
                    "keeps the tighter of the two")
      ->type_name("auto|flow|collapse");
}

CLI::Option* add_topology(CLI::App& app, BakeOptions& options) {
  return add_choice<Topology>(
             app, "--topology", options.topology,
             {{"any", Topology::any}, {"keep", Topology::keep}, {"simplify", Topology::simplify}},
             "any (default): whatever is tightest; keep: the genus of the source; simplify: fewer handles")
      ->type_name("any|keep|simplify");
}

CLI::Option* add_threads(CLI::App& app, BakeOptions& options) {
  return app.add_option("--threads", options.threads, "Threads, 0 for all; the result does not depend on it")
      ->check(CLI::Range(0, 1024).description(""))
      ->type_name("N");
}

}  // namespace encage::tool
