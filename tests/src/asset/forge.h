// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "src/asset/aligned_bytes.h"
#include "src/asset/glb.h"
#include "src/asset/index.h"
#include "src/asset/rules.h"
#include "src/files/hash.h"

#include <encage/error.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <new>
#include <span>
#include <string>

namespace encage {

inline std::span<const std::byte> as_byte_span(const std::string& bytes) { return std::as_bytes(std::span(bytes)); }

/// Changes the JSON and the arrays of an asset and computes all hashes anew: the result is what an attacker or a faulty
/// writer could make, and no hash can detect it. The index is dropped, because it would reveal the change.
inline std::string forge(const std::string& asset, const std::function<void(nlohmann::json&)>& edit_json,
                         const std::function<void(std::string& bin)>& edit_bin = {}) {
  const Glb glb = parse_glb(as_byte_span(asset), "asset");
  nlohmann::json document = nlohmann::json::parse(glb.json);
  std::string bin(reinterpret_cast<const char*>(glb.bin.data()), glb.bin.size() - seal_size);
  auto& sections = document["extensions"][asset_extension]["sections"];
  if (!sections.empty() && sections.back()["name"] == index_name) {
    const auto& view = document["bufferViews"][sections.back()["bufferView"].get<std::size_t>()];
    std::fill_n(bin.begin() + view["byteOffset"].get<std::ptrdiff_t>(), view["byteLength"].get<std::size_t>(), '\0');
    sections.erase(sections.size() - 1);
  }
  if (edit_bin) {
    edit_bin(bin);
    for (auto& section : sections) {
      const auto& view = document["bufferViews"][section["bufferView"].get<std::size_t>()];
      section["hash"] =
          to_string(hash_bytes(as_byte_span(bin).subspan(view["byteOffset"].get<std::size_t>(), view["byteLength"])));
    }
  }
  if (edit_json) edit_json(document);
  std::string bytes = glb_head(document.dump(), bin.size() + seal_size, "forged");
  const std::string head_hash = to_string(hash_bytes(as_byte_span(bytes)));
  bytes += bin + head_hash;
  return bytes + to_string(hash_bytes(as_byte_span(bytes)));
}

/// Offset of an asset's section within the file.
inline std::size_t section_offset(const std::string& asset, const std::string& name) {
  const Glb glb = parse_glb(as_byte_span(asset), "asset");
  const nlohmann::json document = nlohmann::json::parse(glb.json);
  for (const auto& section : document["extensions"][asset_extension]["sections"]) {
    if (section["name"] != name) continue;
    const auto& view = document["bufferViews"][section["bufferView"].get<std::size_t>()];
    return glb.head.size() + view["byteOffset"].get<std::size_t>();
  }
  ADD_FAILURE() << "no section " << name;
  return 0;
}

inline std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// A file for this test alone, removed at the end.
class TemporaryFile {
 public:
  TemporaryFile() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) / (std::string("encage_") + test->test_suite_name() + "_" +
                                                           test->name() + "_" + std::to_string(::getpid()) + ".glb");
    std::filesystem::remove(path_);
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Returns the message of the Error that `action` throws; fails if it throws none.
template <class Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no Error thrown";
  return {};
}

}  // namespace encage
