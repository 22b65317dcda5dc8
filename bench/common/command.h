// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Command lines of the benches. CLI11's templates take ten seconds to compile in every file that instantiates them:
// command.cpp does so for all.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace encage::bench {

/// An option while it is being defined. Its calls return the option itself, so that they can be chained.
class CommandOption {
 public:
  explicit CommandOption(CLI::Option* option) : option_(option) {}

  CommandOption required();
  /// The help says what the value is without the option.
  CommandOption shows_default();
  CommandOption shows_default(const std::string& text);
  /// What stands for the value in the help, e.g. "FILE.glb".
  CommandOption type(const std::string& name);
  /// Refuse numbers outside, between() for integers; the limits themselves are allowed.
  CommandOption between(std::int64_t least, std::int64_t most);
  CommandOption within(double least, double most);
  /// Refuses other words; of a list, in any of its entries.
  CommandOption one_of(const std::vector<std::string>& words);
  /// Must not or must be given together with the other one.
  CommandOption excludes(CommandOption other);
  CommandOption needs(CommandOption other);
  /// Read from an environment variable where the command line lacks it.
  CommandOption environment(const std::string& variable);

 private:
  CLI::Option* option_;
};

/// The options of a program or of a subcommand. What they are written to has to outlive the parsing.
class CommandOptions {
 public:
  explicit CommandOptions(CLI::App& app) : app_(app) {}

  /// "--name" or, without dashes, a positional argument. T: int, std::int64_t, std::uint64_t, double, std::string, a
  /// path, or a list of strings, paths or numbers. Lists are separated by commas if they have a name.
  template <class T>
  CommandOption add(const std::string& name, T& value, const std::string& help);
  CommandOption flag(const std::string& name, bool& value, const std::string& help);

  // What most benches have. Several take it, hence the same name, limits and words.
  CommandOption asset(std::filesystem::path& file, const std::string& help = "Asset of all bodies");
  CommandOption poses(std::filesystem::path& file);  ///< required
  CommandOption every(std::int64_t& every);          ///< K of "every K-th step"
  CommandOption steps(int& steps, const std::string& help);
  CommandOption runs(int& runs, const std::string& help);
  CommandOption threads(int& threads, const std::string& help);
  CommandOption json(std::filesystem::path& file);

 private:
  CLI::App& app_;
};

/// One question that a bench answers: a program, or a subcommand of one.
struct Command {
  std::string name, description;
  std::string examples;  ///< and the meaning of the exit status: the end of the help
  std::function<void(CommandOptions& options)> define;
  std::function<bool()> run;  ///< false, exit status 1: the answer is no
};

/// A command with arguments of type Arguments, made by their default constructor.
template <class Arguments>
Command make_command(std::string name, std::string description, std::string examples,
                     void (*define)(CommandOptions& options, Arguments& arguments), bool (*run)(Arguments& arguments)) {
  const auto arguments = std::make_shared<Arguments>();
  return {std::move(name), std::move(description), std::move(examples),
          [define, arguments](CommandOptions& options) { define(options, *arguments); },
          [run, arguments] { return run(*arguments); }};
}

/// What main() of a bench does: parses, runs, and returns the exit status. Errors go to stderr.
int run_command(const Command& command, int argc, char** argv);

/// The same for a program whose first argument names one of the commands.
int run_commands(const std::string& program, const std::string& description, const std::vector<Command>& commands,
                 int argc, char** argv);

/// Throws Error, before any long work, if one of the outputs cannot be written or is one of the inputs. Empty paths are
/// left out.
void check_outputs(std::initializer_list<std::filesystem::path> outputs,
                   std::initializer_list<std::filesystem::path> inputs);

}  // namespace encage::bench
