// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace CLI {  // its headers take seconds to compile
class App;
class Option;
}  // namespace CLI

namespace encage::tool {

// Where programs write their results. "-" is standard output, whose other names are known too (/dev/stdout).

bool is_standard_output(const std::filesystem::path& file);

/// Whether what has that name need not have the extension of a format: standard output, a device, a pipe.
bool has_no_format(const std::filesystem::path& file);

/// The file to write: "-" becomes the name that the system has for standard output.
std::filesystem::path output_path(const std::filesystem::path& file);

/// How messages call it: "standard output" for "-".
std::string output_name(const std::filesystem::path& file);

/// If `file` is standard output, what the program prints from now on goes to standard error: results and reports do not
/// mix.
void print_beside(const std::filesystem::path& file);

/// `--json [FILE]`, which means the same in every program: the figures as JSON to FILE, beside what is printed; without
/// FILE, or with "-", to standard output instead of what is printed. `file` has to outlive the parsing; it stays empty
/// without the option.
CLI::Option* add_json(CLI::App& app, std::filesystem::path& file,
                      const std::string& description = "Write the figures as JSON; without FILE instead of the text");

/// Throws Error, before any long work, if `file` cannot be written: no such folder, no permission, a folder of that
/// name, or the input itself.
void check_output(const std::filesystem::path& file, const std::filesystem::path& input);

/// Throws Error if two results would go to the same file.
void check_different(const std::filesystem::path& a, const std::filesystem::path& b);

/// Where `encage bake INPUT` alone writes: INPUT's name with .glb in the current folder, or .cages.glb if that is the
/// input itself. Throws Error if a file of that name exists that is no asset of ours, and for an input that is no
/// regular file and hence has no name to use.
std::filesystem::path default_asset(const std::filesystem::path& input);

/// Indented, with a newline at the end. A regular file is replaced whole or left untouched.
void write_json(const std::filesystem::path& file, const nlohmann::ordered_json& json);

}  // namespace encage::tool
