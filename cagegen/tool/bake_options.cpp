// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/bake_options.h"

#include <cstdint>
#include <limits>
#include <map>
#include <string>

namespace encage::tool {

namespace {

/// An option whose values are words.
template <class T>
CLI::Option* add_choice(CLI::App& app, const std::string& option, T& target, const std::map<std::string, T>& words,
                        const std::string& description) {
  return app
      .add_option_function<std::string>(
          option, [&target, words](const std::string& word) { target = words.at(word); }, description)
      ->check(CLI::IsMember(words).description(""));
}

}  // namespace

CLI::Option* add_faces(CLI::App& app, BakeOptions& options) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  return app.add_option("--faces", options.faces, "Triangles per level, fine to coarse, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(std::int64_t{4}, most).description(""))
      ->type_name("N,...")
      ->allow_extra_args(false);
}

CLI::Option* add_method(CLI::App& app, BakeOptions& options) {
  return add_choice<BakeMethod>(app, "--method", options.method,
                                {{"auto", BakeMethod::automatic}, {"collapse", BakeMethod::collapse}},
                                "How cages are made; by default auto, which tries all methods")
      ->type_name("auto|collapse");
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
