// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/output_file.h"

#include "cagegen/cli/cage_json.h"
#include "cagegen/cli/is_asset.h"
#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>
#include <streambuf>
#include <string>
#include <system_error>

namespace encage::tool {

namespace fs = std::filesystem;

namespace {

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code missing;
  return fs::equivalent(a, b, missing);
}

/// Swallows what is printed.
class NullBuffer : public std::streambuf {
 protected:
  int_type overflow(int_type c) override { return traits_type::not_eof(c); }
  std::streamsize xsputn(const char*, std::streamsize count) override { return count; }
};

void mute_standard_output() {
  static auto* const buffer = new NullBuffer;  // std::cout uses it until the very end
  std::cout.flush();
  std::cout.rdbuf(buffer);
}

}  // namespace

bool is_standard_output(const fs::path& file) {
  for (const char* name : {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
    if (file == name) return true;
  }
  return false;
}

bool has_no_format(const fs::path& file) { return is_standard_output(file) || is_written_through(file); }

fs::path output_path(const fs::path& file) { return file == "-" ? fs::path("/dev/stdout") : file; }

std::string output_name(const fs::path& file) { return file == "-" ? "standard output" : file.string(); }

void print_beside(const fs::path& file) {
  if (!is_standard_output(file)) return;
  std::cout.flush();
  std::cout.rdbuf(std::cerr.rdbuf());
}

CLI::Option* add_json(CLI::App& app, fs::path& file, const std::string& description) {
  return app
      .add_option_function<std::string>(
          "--json",
          [&file](const std::string& name) {
            file = name.empty() ? "-" : name;
            if (is_standard_output(file)) mute_standard_output();
          },
          description)
      ->expected(0, 1)
      ->type_name("[FILE]");
}

void check_output(const fs::path& file, const fs::path& input) {
  if (is_standard_output(file)) return;
  std::error_code error;
  const fs::file_type type = fs::status(file, error).type();
  if (type == fs::file_type::none) throw Error(file.string() + ": cannot write: " + error.message());
  if (type == fs::file_type::directory) throw Error(file.string() + ": is a folder");
  if (is_written_through(file)) {
    if (access(file.c_str(), W_OK) != 0) throw Error(file.string() + ": cannot write: " + std::strerror(errno));
    return;
  }
  const fs::path target = follow_links(file);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(folder)) throw Error(file.string() + ": no such folder: " + folder.string());
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw Error(file.string() + ": cannot write: " + std::strerror(errno));
  }
  if (same_file(file, input)) throw Error(file.string() + ": would overwrite the input");
}

void check_different(const fs::path& a, const fs::path& b) {
  const bool standard = is_standard_output(a) && is_standard_output(b);
  if (!standard && has_no_format(a)) return;
  if (standard || a.lexically_normal() == b.lexically_normal() || same_file(a, b)) {
    throw Error(a.string() + ": two results cannot go to the same file");
  }
}

fs::path default_asset(const fs::path& input) {
  std::error_code none;  // whoever opens a file says what is wrong with its name
  if (!fs::is_regular_file(input, none) && (input == "-" || fs::exists(input, none))) {
    throw Error(input.string() + ": has no name to use for the output; choose it with -o");
  }
  fs::path file = input.filename().replace_extension(".glb");
  if (same_file(file, input)) file.replace_extension(".cages.glb");
  if (fs::exists(file, none) && !is_asset(file)) {
    throw Error(file.string() + ": exists and holds no cages; choose the output with -o");
  }
  return file;
}

void write_json(const fs::path& file, const nlohmann::ordered_json& json) {
  write_atomically(output_path(file), dump(json));
}

}  // namespace encage::tool
