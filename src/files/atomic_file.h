// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace encage {

/// Writes `bytes` to a temporary beside `file`, then renames it: a reader sees
/// the old content or the new one, and a failure leaves the old one untouched
/// and no temporary behind. Throws Error naming the file and the reason.
void write_atomically(const std::filesystem::path& file, std::string_view bytes);

}  // namespace encage
