// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace encage {

/// Reads a file to its end: a regular file, a pipe or a device. Throws Error naming the file and the reason.
std::string read_file(const std::filesystem::path& file);

/// Reads standard input to its end; `name` stands for it in messages.
std::string read_standard_input(const std::filesystem::path& name);

}  // namespace encage
