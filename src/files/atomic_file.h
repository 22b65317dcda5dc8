// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace encage {

/// Whether `file` is written through and not replaced: a device, a pipe or a socket, or a name of a descriptor of this
/// process (/dev/stdout, /dev/fd/3).
bool is_written_through(const std::filesystem::path& file);

/// Returns where the links lead of which `file` is the first; what they lead to need not exist. Throws Error naming the
/// file for links that go round in circles.
std::filesystem::path follow_links(const std::filesystem::path& file);

/// Makes `bytes` the content of `file`. A regular file, or a new one, is replaced: a temporary beside it is written,
/// then renamed, so that a reader sees the old content or the new one. A failure leaves the old file untouched and
/// removes the temporary. A link stays, and what it leads to is replaced. Where is_written_through() holds, the bytes
/// are written to what is there. `inspect`, unless empty, is called with the temporary's path while `file` is still the
/// old one; if it throws, nothing is replaced. It is not called where there is no temporary. May be called from any
/// thread. Throws Error naming the file and the reason, and whatever `inspect` throws.
void write_atomically(const std::filesystem::path& file, std::string_view bytes,
                      const std::function<void(const std::filesystem::path& temporary)>& inspect = {});

}  // namespace encage
