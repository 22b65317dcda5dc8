// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/output_file.h"

#include "cagegen/cli/cage_json.h"
#include "cagegen/cli/is_asset.h"
#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace encage::tool {

namespace fs = std::filesystem;

namespace {

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code missing;
  return fs::equivalent(a, b, missing);
}

}  // namespace

void check_output(const fs::path& file, const fs::path& input) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder)) throw Error(file.string() + ": no such folder: " + folder.string());
  if (fs::is_directory(file)) throw Error(file.string() + ": is a folder");
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw Error(file.string() + ": cannot write: " + std::strerror(errno));
  }
  if (same_file(file, input)) throw Error(file.string() + ": would overwrite the input");
}

fs::path default_asset(const fs::path& input) {
  fs::path file = input.filename().replace_extension(".glb");
  if (same_file(file, input)) file.replace_extension(".cages.glb");
  if (fs::exists(file) && !is_asset(file)) {
    throw Error(file.string() + ": exists and holds no cages; choose the output with -o");
  }
  return file;
}

void write_json(const fs::path& file, const nlohmann::ordered_json& json) { write_atomically(file, dump(json)); }

}  // namespace encage::tool
