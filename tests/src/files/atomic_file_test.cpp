// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/files/atomic_file.h"

#include "tests/src/asset/forge.h"

#include <encage/error.h>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace encage {
namespace {

namespace fs = std::filesystem;

/// A folder of this test alone, removed at the end.
class Folder {
 public:
  Folder() { fs::create_directories(file_.path()); }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(file_.path(), ignored);
    fs::create_directories(file_.path(), ignored);  // for `file_` to remove
  }
  fs::path operator/(const std::string& name) const { return file_.path() / name; }
  std::size_t size() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(file_.path()), fs::directory_iterator()));
  }

 private:
  TemporaryFile file_;
};

mode_t current_umask() {
  const mode_t mask = umask(0);
  umask(mask);
  return mask;
}

TEST(AtomicFile, replaces_a_file_and_leaves_nothing_else) {
  const Folder folder;
  write_atomically(folder / "a", "first");
  write_atomically(folder / "a", "second");
  EXPECT_EQ(read_bytes(folder / "a"), "second");
  EXPECT_EQ(folder.size(), 1u);
  EXPECT_THROW(write_atomically(folder / "missing" / "a", "x"), Error);
  fs::create_directory(folder / "full");
  write_bytes(folder / "full" / "b", "x");
  EXPECT_EQ(error_of([&] { write_atomically(folder / "full", "x"); }),
            (folder / "full").string() + ": cannot replace: Is a directory");
  EXPECT_EQ(folder.size(), 2u);
}

TEST(AtomicFile, has_the_permissions_of_an_ordinary_file) {
  const Folder folder;
  const mode_t before = umask(027);
  write_atomically(folder / "a", "x");
  umask(before);
  struct stat status {};
  ASSERT_EQ(stat((folder / "a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, mode_t{0640});
}

TEST(AtomicFile, shows_the_temporary_before_it_replaces_anything) {
  const Folder folder;
  write_atomically(folder / "a", "old");
  write_atomically(folder / "a", "new", [&](const fs::path& temporary) {
    EXPECT_EQ(read_bytes(temporary), "new");
    EXPECT_EQ(read_bytes(folder / "a"), "old");
  });
  EXPECT_EQ(read_bytes(folder / "a"), "new");
  EXPECT_THROW(write_atomically(folder / "a", "bad", [](const fs::path&) { throw std::runtime_error("no"); }),
               std::runtime_error);
  EXPECT_EQ(read_bytes(folder / "a"), "new");
  EXPECT_EQ(folder.size(), 1u);
}

TEST(AtomicFile, threads_leave_the_umask_alone) {
  const Folder folder;
  const mode_t before = umask(022);
  std::atomic<int> world_writable{0};
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 200; ++i) {
        write_atomically(folder / std::to_string(t), std::to_string(i));
        struct stat status {};
        if (stat((folder / std::to_string(t)).c_str(), &status) != 0 || (status.st_mode & 022) != 0) ++world_writable;
      }
    });
  }
  threads.clear();
  EXPECT_EQ(current_umask(), mode_t{022});
  umask(before);
  EXPECT_EQ(world_writable, 0);
  EXPECT_EQ(folder.size(), 4u);
}

}  // namespace
}  // namespace encage
