// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace encage {

/// Writes `bytes` to a temporary beside `file`, then renames it: a reader sees the old content or the new one, and a
/// failure leaves the old one untouched and no temporary behind. `inspect`, unless empty, is given the temporary while
/// `file` is still the old one; if it throws, nothing is replaced. From any thread. Throws Error naming the file and
/// the reason, and what `inspect` throws.
void write_atomically(const std::filesystem::path& file, std::string_view bytes,
                      const std::function<void(const std::filesystem::path& temporary)>& inspect = {});

}  // namespace encage
