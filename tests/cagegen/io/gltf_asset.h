// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

// glTF files that tests make.

namespace encage::test {

inline std::string base64(std::string_view bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) text += k < bytes.size() - i + 1 ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <typename T>
std::string bytes_of_values(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// A glTF file whose JSON is there to be changed. Every buffer view lies in one buffer.
struct GltfAsset {
  using Json = nlohmann::json;

  Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string data;

  /// One node with one mesh of one primitive, triangles of these points. Indices may be empty.
  static GltfAsset mesh(const std::vector<float>& points, const std::vector<std::uint16_t>& indices = {}) {
    GltfAsset asset;
    Json primitive = {{"attributes", {{"POSITION", asset.add("VEC3", points)}}}};
    if (!indices.empty()) primitive["indices"] = asset.add("SCALAR", indices);
    asset.json["meshes"] = {{{"primitives", {primitive}}}};
    asset.json["nodes"] = {{{"mesh", 0}}};
    asset.json["scenes"] = {{{"nodes", {0}}}};
    return asset;
  }
  static GltfAsset triangle() { return mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}); }

  Json& node(int number) { return json["nodes"][static_cast<std::size_t>(number)]; }
  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  Json& attributes() { return primitive()["attributes"]; }

  /// Returns the number of the new buffer view.
  int add_view(std::string_view bytes, Json view = Json::object()) {
    data.resize((data.size() + 3) / 4 * 4, '\0');
    view["buffer"] = 0;
    view["byteOffset"] = data.size();
    view["byteLength"] = bytes.size();
    data += bytes;
    json["bufferViews"].push_back(view);
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
  /// Returns the number of the new accessor.
  int add_accessor(const Json& accessor) {
    json["accessors"].push_back(accessor);
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  template <typename T>
  int add(const std::string& type, const std::vector<T>& values, Json accessor = Json::object()) {
    accessor["type"] = type;
    accessor["componentType"] = component<T>();
    accessor["count"] = values.size() / (type == "SCALAR" ? 1 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16);
    accessor["bufferView"] = add_view(bytes_of_values(values));
    return add_accessor(accessor);
  }
  void require(const std::string& extension) {
    json["extensionsUsed"].push_back(extension);
    json["extensionsRequired"].push_back(extension);
  }

  template <typename T>
  static constexpr int component() {
    if constexpr (std::is_same_v<T, float>) return 5126;
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    return 5125;
  }

  /// A .gltf file with its data inside.
  std::string text() const {
    Json all = json;
    if (!data.empty() && !all.contains("buffers")) all["buffers"] = Json::array({Json::object()});
    if (!data.empty()) {
      all["buffers"][0]["byteLength"] = data.size();
      if (!all["buffers"][0].contains("uri"))
        all["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(data);
    }
    return all.dump();
  }
  /// A .glb file.
  std::string binary() const {
    Json all = json;
    if (!all.contains("buffers")) all["buffers"] = Json::array({Json::object()});
    all["buffers"][0]["byteLength"] = data.size();
    std::string text = all.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string chunk = data;
    chunk.resize((chunk.size() + 3) / 4 * 4, '\0');
    const auto word = [](std::size_t value) {
      const auto number = static_cast<std::uint32_t>(value);
      return std::string(reinterpret_cast<const char*>(&number), sizeof number);
    };
    return "glTF" + word(2) + word(28 + text.size() + chunk.size()) + word(text.size()) + "JSON" + text +
           word(chunk.size()) + std::string("BIN\0", 4) + chunk;
  }
};

}  // namespace encage::test
