// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/files/read_file.h"

#include "tests/src/asset/forge.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <thread>

namespace encage {
namespace {

TEST(ReadFile, reads_files_of_any_size) {
  const TemporaryFile file;
  for (const std::size_t size : {0U, 1U, 65535U, 65536U, 65537U, 1000000U}) {
    const std::string bytes(size, 'x');
    write_bytes(file.path(), bytes);
    EXPECT_EQ(read_file(file.path()), bytes);
  }
  EXPECT_NE(read_file("/proc/self/status"), "");  // a regular file whose size is said to be 0
}

TEST(ReadFile, reads_pipes) {
  const TemporaryFile file;
  ASSERT_EQ(mkfifo(file.path().c_str(), 0600), 0);
  const std::string bytes(300000, 'x');
  std::jthread writer([&] { write_bytes(file.path(), bytes); });
  EXPECT_EQ(read_file(file.path()), bytes);
}

TEST(ReadFile, names_what_cannot_be_read) {
  EXPECT_EQ(error_of([] { read_file("missing.obj"); }), "missing.obj: cannot open: No such file or directory");
  EXPECT_EQ(error_of([] { read_file("/tmp"); }), "/tmp: cannot read: Is a directory");
}

}  // namespace
}  // namespace encage
