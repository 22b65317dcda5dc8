// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

// Files that are read, or refused with a message.

namespace encage::test {

/// The message with which a file is refused; empty if it is read.
inline std::string refusal(const std::string& name, std::string_view bytes) {
  const Folder folder;
  const std::filesystem::path file = folder.write(name, bytes);
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  std::string message;
  try {
    read_polygon_mesh(file);
  } catch (const Error& error) {
    message = error.what();
    EXPECT_EQ(message.find(file.string() + ": "), 0u) << message;
    message = message.substr(file.string().size() + 2);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  return message;
}

inline PolygonMesh read(const std::string& name, std::string_view bytes) {
  const Folder folder;
  return read_polygon_mesh(folder.write(name, bytes));
}

/// What the reader notes, in one line.
inline std::string notes_of(const std::string& name, std::string_view bytes) {
  const Folder folder;
  ReadNotes notes;
  read_polygon_mesh(folder.write(name, bytes), &notes);
  std::string text;
  for (const std::string& note : notes) text += (text.empty() ? "" : " | ") + note;
  return text;
}

template <typename T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  return bytes;
}

inline std::string binary_stl(std::uint32_t promised, const std::vector<std::array<float, 9>>& triangles) {
  std::string bytes = "solid, but binary";
  bytes.resize(80, '\0');
  bytes += raw({promised});
  for (const auto& t : triangles) {
    bytes += raw({0.f, 0.f, 1.f}) + std::string(reinterpret_cast<const char*>(t.data()), 36) + std::string(2, '\0');
  }
  return bytes;
}

inline std::vector<std::int32_t> indices(std::initializer_list<std::int32_t> list) { return list; }

}  // namespace encage::test
