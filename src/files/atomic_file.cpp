// SPDX-License-Identifier: Apache-2.0
#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace encage {

void write_atomically(const std::filesystem::path& file, std::string_view bytes) {
  std::string temporary = file.string() + ".XXXXXX";
  const int descriptor = mkstemp(temporary.data());
  if (descriptor < 0) throw Error(file.string() + ": cannot write: " + std::strerror(errno));
  const auto fail = [&](const char* what) {
    const std::string reason = std::strerror(errno);
    close(descriptor);
    unlink(temporary.c_str());
    throw Error(file.string() + ": " + what + ": " + reason);
  };
  // mkstemp makes the file private; give it the permissions that an ordinary open would.
  const mode_t mask = umask(0);
  umask(mask);
  if (fchmod(descriptor, 0666 & ~mask) != 0) fail("cannot set permissions");
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot write");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  if (fsync(descriptor) != 0 && errno != EINVAL) fail("cannot write");
  if (std::rename(temporary.c_str(), file.c_str()) != 0) fail("cannot replace");
  close(descriptor);
}

}  // namespace encage
