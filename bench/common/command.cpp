// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/command.h"

#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"

#include <CLI/CLI.hpp>

namespace encage::bench {
namespace {

constexpr std::int64_t many = 1'000'000'000;

// The help lists limits in words of its own.
template <class Check>
CLI::Validator silent(Check check) {
  return check.description("");
}

template <class T>
constexpr bool is_list = false;
template <class T>
constexpr bool is_list<std::vector<T>> = true;

int parse_and_run(CLI::App& app, int argc, char** argv, const std::function<bool()>& run) {
  return tool::run_program(app, argc, argv, [&]() -> int { return run() ? tool::success : tool::answer_is_no; });
}

}  // namespace

CommandOption CommandOption::required() { return option_->required(), *this; }
CommandOption CommandOption::shows_default() { return option_->capture_default_str(), *this; }
CommandOption CommandOption::shows_default(const std::string& text) { return option_->default_str(text), *this; }
CommandOption CommandOption::type(const std::string& name) { return option_->type_name(name), *this; }
CommandOption CommandOption::between(std::int64_t least, std::int64_t most) {
  return option_->check(silent(CLI::Range(least, most))), *this;
}
CommandOption CommandOption::within(double least, double most) {
  return option_->check(silent(CLI::Range(least, most))), *this;
}
CommandOption CommandOption::one_of(const std::vector<std::string>& words) {
  return option_->check(silent(CLI::IsMember(words))), *this;
}
CommandOption CommandOption::excludes(CommandOption other) { return option_->excludes(other.option_), *this; }
CommandOption CommandOption::needs(CommandOption other) { return option_->needs(other.option_), *this; }
CommandOption CommandOption::environment(const std::string& variable) { return option_->envname(variable), *this; }

template <class T>
CommandOption CommandOptions::add(const std::string& name, T& value, const std::string& help) {
  CLI::Option* option = app_.add_option(name, value, help);
  if constexpr (is_list<T>) {
    if (!option->get_positional()) option->delimiter(',')->allow_extra_args(false);
  }
  return CommandOption(option);
}

template CommandOption CommandOptions::add(const std::string&, int&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::int64_t&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::uint64_t&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, double&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::string&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::filesystem::path&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::vector<int>&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::vector<std::int64_t>&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::vector<std::string>&, const std::string&);
template CommandOption CommandOptions::add(const std::string&, std::vector<std::filesystem::path>&, const std::string&);

CommandOption CommandOptions::flag(const std::string& name, bool& value, const std::string& help) {
  return CommandOption(app_.add_flag(name, value, help));
}

CommandOption CommandOptions::asset(std::filesystem::path& file, const std::string& help) {
  return add("--asset", file, help).type("FILE.glb");
}
CommandOption CommandOptions::poses(std::filesystem::path& file) {
  return add("--poses", file, "Poses of the bodies, step by step").required().type("FILE.csv");
}
CommandOption CommandOptions::every(std::int64_t& every) {
  return add("--every", every, "Take every K-th step only").between(1, many).shows_default().type("K");
}
CommandOption CommandOptions::steps(int& steps, const std::string& help) {
  return add("--steps", steps, help).between(1, 1'000'000).shows_default().type("N");
}
CommandOption CommandOptions::runs(int& runs, const std::string& help) {
  return add("--runs", runs, help).between(1, 1'000'000).shows_default().type("N");
}
CommandOption CommandOptions::threads(int& threads, const std::string& help) {
  return add("--threads", threads, help).between(0, 1024).type("N");
}
CommandOption CommandOptions::json(std::filesystem::path& file) {
  return CommandOption(tool::add_json(app_, file, "Write everything as JSON; without FILE instead of the text"));
}

int run_command(const Command& command, int argc, char** argv) {
  CLI::App app(command.description, command.name);
  app.footer(command.examples);
  CommandOptions options(app);
  command.define(options);
  return parse_and_run(app, argc, argv, command.run);
}

int run_commands(const std::string& program, const std::string& description, const std::vector<Command>& commands,
                 int argc, char** argv) {
  CLI::App app(description, program);
  app.require_subcommand(1);
  std::function<bool()> run;
  for (const Command& command : commands) {
    CLI::App* sub = app.add_subcommand(command.name, command.description);
    sub->footer(command.examples);
    CommandOptions options(*sub);
    command.define(options);
    sub->callback([&run, &command] { run = command.run; });
  }
  return parse_and_run(app, argc, argv, [&] { return run(); });
}

void check_outputs(std::initializer_list<std::filesystem::path> outputs,
                   std::initializer_list<std::filesystem::path> inputs) {
  for (const auto& output : outputs) {
    if (output.empty()) continue;
    tool::check_output(output, {});
    for (const auto& input : inputs) tool::check_output(output, input);
  }
}

}  // namespace encage::bench
