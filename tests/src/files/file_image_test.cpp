// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/files/file_image.h"

#include "tests/src/asset/forge.h"

#include <encage/error.h>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

namespace encage {
namespace {

using ::testing::TempDir;

std::string text(const FileImage& image) {
  return {reinterpret_cast<const char*>(image.bytes().data()), image.bytes().size()};
}

FileImage whole_copy(const std::filesystem::path& file) {
  FileImage image(file, LoadMode::copy);
  image.fetch(image.bytes());
  return image;
}

TEST(FileImage, shows_the_bytes_and_survives_moves) {
  const TemporaryFile file;
  write_bytes(file.path(), "some bytes");
  FileImage image(file.path(), LoadMode::map);
  EXPECT_EQ(text(image), "some bytes");
  FileImage second(std::move(image));
  EXPECT_EQ(text(second), "some bytes");
  EXPECT_EQ(text(whole_copy(file.path())), "some bytes");
  write_bytes(file.path(), "others");
  second = FileImage(file.path(), LoadMode::map);
  EXPECT_EQ(text(second), "others");
}

TEST(FileImage, empty_file_has_no_bytes) {
  const TemporaryFile file;
  write_bytes(file.path(), "");
  EXPECT_TRUE(FileImage(file.path(), LoadMode::map).bytes().empty());
  EXPECT_TRUE(whole_copy(file.path()).bytes().empty());
}

TEST(FileImage, refuses_what_is_no_regular_file) {
  for (const LoadMode mode : {LoadMode::map, LoadMode::copy}) {
    const TemporaryFile file;
    EXPECT_EQ(error_of([&] { FileImage(file.path(), mode); }),
              file.path().string() + ": cannot open: No such file or directory");
    EXPECT_EQ(error_of([&] { FileImage(TempDir(), mode); }), TempDir() + ": not a regular file");
    ASSERT_EQ(mkfifo(file.path().c_str(), 0600), 0);
    EXPECT_EQ(error_of([&] { FileImage(file.path(), mode); }), file.path().string() + ": not a regular file");
  }
}

/// Three pages and a little, every byte of a page the same.
std::string pages() {
  const auto size = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return std::string(size, 'a') + std::string(size, 'b') + std::string(size, 'c') + "de";
}

TEST(FileImage, a_copy_has_what_was_fetched_until_it_is_discarded) {
  const TemporaryFile file;
  const std::string content = pages();
  write_bytes(file.path(), content);
  const std::size_t page = content.size() / 3;
  FileImage image(file.path(), LoadMode::copy);
  EXPECT_EQ(text(image), std::string(content.size(), '\0'));
  image.fetch(image.bytes().subspan(page - 1, page + 3));
  EXPECT_EQ(text(image).substr(page - 2, page + 6),
            std::string("\0a", 2) + content.substr(page, page + 2) + std::string(2, '\0'));
  image.close();
  image.fetch(image.bytes());
  EXPECT_EQ(text(image), content);
  // Whole pages only: the others belong to neighbours, too.
  image.discard(image.bytes().subspan(1, 2 * page));
  EXPECT_EQ(text(image), content.substr(0, page) + std::string(page, '\0') + content.substr(2 * page));
  image.discard(image.bytes().subspan(2 * page + 1, 10));
  EXPECT_EQ(text(image), content.substr(0, page) + std::string(page, '\0') + content.substr(2 * page));
}

TEST(FileImage, a_map_finds_discarded_bytes_in_the_file) {
  const TemporaryFile file;
  write_bytes(file.path(), pages());
  FileImage image(file.path(), LoadMode::map);
  image.discard(image.bytes());
  EXPECT_EQ(text(image), pages());
}

TEST(FileImage, leaves_memory_of_others_alone) {
  const TemporaryFile file;
  write_bytes(file.path(), pages());
  const auto size = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* const memory = mmap(nullptr, 2 * size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  std::memset(memory, 'x', 2 * size);
  const std::span foreign(static_cast<const std::byte*>(memory), 2 * size);
  for (const LoadMode mode : {LoadMode::map, LoadMode::copy}) {
    FileImage image(file.path(), mode);
    image.fetch(image.bytes());
    image.discard(foreign);
    image.fetch(foreign);
    FileImage().discard(foreign);
    EXPECT_EQ(std::string(static_cast<const char*>(memory), 2 * size), std::string(2 * size, 'x'));
    EXPECT_EQ(text(image), pages());
  }
  munmap(memory, 2 * size);
}

TEST(FileImage, a_copy_survives_what_becomes_of_the_file) {
  const TemporaryFile file;
  write_bytes(file.path(), pages());
  FileImage image = whole_copy(file.path());
  image.close();
  std::filesystem::resize_file(file.path(), 5);
  EXPECT_EQ(text(image), pages());
  EXPECT_EQ(error_of([&] { image.fetch(image.bytes()); }), file.path().string() +
                                                               ": cannot read: the file ends after 5 of its " +
                                                               std::to_string(pages().size()) + " bytes");
  image.close();
  std::filesystem::remove(file.path());
  EXPECT_EQ(error_of([&] { image.fetch(image.bytes()); }),
            file.path().string() + ": cannot open: No such file or directory");
}

}  // namespace
}  // namespace encage
