// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace encage {

/// Writes `bytes` to a temporary file beside `file`, then renames it: a reader sees the old content or the new one. A
/// failure leaves the old file untouched and removes the temporary. `inspect`, unless empty, is called with the
/// temporary's path while `file` is still the old one; if it throws, nothing is replaced. May be called from any
/// thread. Throws Error naming the file and the reason, and whatever `inspect` throws.
void write_atomically(const std::filesystem::path& file, std::string_view bytes,
                      const std::function<void(const std::filesystem::path& temporary)>& inspect = {});

}  // namespace encage
