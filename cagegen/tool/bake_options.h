// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <CLI/CLI.hpp>

#include <map>
#include <string>

namespace encage::tool {

// Options that several programs have. `options` has to outlive the parsing.

/// An option whose values are words.
template <class T>
CLI::Option* add_choice(CLI::App& app, const std::string& option, T& target, const std::map<std::string, T>& words,
                        const std::string& description) {
  return app
      .add_option_function<std::string>(
          option, [&target, words](const std::string& word) { target = words.at(word); }, description)
      ->check(CLI::IsMember(words).description(""));
}

/// `--faces N,...`, every number at least 4.
CLI::Option* add_faces(CLI::App& app, BakeOptions& options);

/// "auto", "flow", "collapse".
const std::map<std::string, BakeMethod>& method_names();

/// `--method auto|flow|collapse`.
CLI::Option* add_method(CLI::App& app, BakeOptions& options);

/// `--topology any|keep|simplify`.
CLI::Option* add_topology(CLI::App& app, BakeOptions& options);

/// `--threads N`.
CLI::Option* add_threads(CLI::App& app, BakeOptions& options);

}  // namespace encage::tool
