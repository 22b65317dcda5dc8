// SPDX-License-Identifier: Apache-2.0
#include "src/asset/writer.h"

#include "src/asset/glb.h"
#include "src/asset/index.h"
#include "src/asset/json.h"
#include "src/asset/rules.h"
#include "src/asset/view.h"
#include "src/files/atomic_file.h"
#include "src/files/hash.h"
#include "src/tree/mesh_arrays.h"

#include <encage/asset.h>
#include <encage/version.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <span>
#include <vector>

namespace encage {
namespace {

using nlohmann::json;  // sorts its keys
using Float3 = std::array<float, 3>;
using Index3 = std::array<std::uint32_t, 3>;

json certificate_json(const Certificate& c) {
  json level = {{"clearance", c.clearance}, {"volume", c.volume}, {"components", c.components},
                {"cavities", c.cavities},   {"genus", c.genus},   {"method", name(c.method)},
                {"start", c.start}};
  if (c.volume_ratio) level["volume_ratio"] = *c.volume_ratio;
  if (c.max_distance) level["max_distance"] = *c.max_distance;
  if (c.mean_distance) level["mean_distance"] = *c.mean_distance;
  if (c.no_new_handles) level["no_new_handles"] = *c.no_new_handles;
  return level;
}

/// Builds the JSON document and the BIN data side by side.
class Encoder {
 public:
  Encoder(const CageHierarchy& hierarchy, const std::string& file) : hierarchy_(hierarchy), file_(file) {}

  std::string encode(const std::string& generator) {
    check_description(hierarchy_, file_);
    check_size();
    json levels = json::array();
    json extension = describe();
    if (hierarchy_.fine.triangles.rows() > 0) {
      extension["fine_mesh"] = add_mesh(hierarchy_.fine, SectionKind::fine, fine_name);
    }
    for (std::size_t i = 0; i < hierarchy_.levels.size(); ++i) {
      levels.push_back(certificate_json(hierarchy_.levels[i].certificate));
      levels.back()["mesh"] = add_mesh(hierarchy_.levels[i].mesh, SectionKind::cage, cage_name(i));
    }
    reserve_index();
    extension["levels"] = std::move(levels);
    extension["sections"] = std::move(sections_);
    finish_document(generator, std::move(extension));
    return seal();
  }

 private:
  /// Throws before anything large is allocated. It uses a lower bound of the size.
  void check_size() const {
    std::uint64_t size = mesh_size(hierarchy_.fine) + seal_size;
    for (const CageLevel& level : hierarchy_.levels) size += mesh_size(level.mesh);
    glb_head("", size, file_);
  }

  static std::uint64_t mesh_size(const TriangleMesh& mesh) {
    return align_up(static_cast<std::uint64_t>(mesh.vertices.rows()) * sizeof(Float3)) +
           align_up(static_cast<std::uint64_t>(mesh.triangles.rows()) * (sizeof(Index3) + sizeof(LeafTriangle)));
  }

  json describe() const {
    const Eigen::Vector3d& o = hierarchy_.origin;
    json extension = {{"version", asset_version},
                      {"origin", {o.x(), o.y(), o.z()}},
                      {"solid", name(hierarchy_.solid)},
                      {"source_hash", to_string(hierarchy_.source_hash)},
                      {"source_volume", hierarchy_.source_volume},
                      {"diagonal", hierarchy_.diagonal},
                      {"cap_count", hierarchy_.cap_count},
                      {"fine_error", hierarchy_.fine_error},
                      {"truncated", hierarchy_.truncated}};
    if (!hierarchy_.options.empty()) {
      extension["options"] = parse_json(hierarchy_.options, file_ + ": options");
      if (!extension["options"].is_object()) throw Error(file_ + ": options: not a JSON object");
    }
    return extension;
  }

  /// Appends the arrays of a mesh, its accessors and its node; returns its index.
  std::size_t add_mesh(const TriangleMesh& mesh, SectionKind kind, const std::string& mesh_name) {
    const std::string place = file_ + ": " + mesh_name;
    const MeshArrays arrays = make_mesh_arrays(mesh, place);
    const std::vector<Float3>& vertices = arrays.vertices;
    const std::vector<Index3>& triangles = arrays.triangles;
    if (kind == SectionKind::fine) check_caps(hierarchy_.cap_count, mesh.triangles.rows(), file_);

    constexpr int array_buffer = 34962, element_array_buffer = 34963;  // glTF 2.0, bufferView.target
    constexpr int float32 = 5126, uint32 = 5125, triangle_mode = 4;
    Float3 low = vertices[0], high = vertices[0];
    for (const Float3& vertex : vertices) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], vertex[k]);
        high[k] = std::max(high[k], vertex[k]);
      }
    }
    const auto add = [&](std::size_t k, const auto& elements, int target = 0) {
      assert(sizeof(elements[0]) == mesh_sections[k].element_size);
      return add_section(elements, kind, section_name(mesh_name, mesh_sections[k]), target);
    };
    const std::size_t accessor = accessors_.size(), index = meshes_.size();
    accessors_.push_back({{"bufferView", add(0, vertices, array_buffer)},
                          {"componentType", float32},
                          {"count", vertices.size()},
                          {"max", high},
                          {"min", low},
                          {"type", "VEC3"}});
    accessors_.push_back({{"bufferView", add(1, triangles, element_array_buffer)},
                          {"componentType", uint32},
                          {"count", triangles.size() * 3},
                          {"type", "SCALAR"}});
    add(2, arrays.tree.nodes);
    add(3, arrays.tree.leaves);
    add(4, arrays.owned);
    add(5, arrays.parts);
    json primitive = {{"attributes", {{"POSITION", accessor}}}, {"indices", accessor + 1}, {"mode", triangle_mode}};
    if (kind == SectionKind::cage) primitive["material"] = 0;
    meshes_.push_back({{"name", mesh_name}, {"primitives", json::array({std::move(primitive)})}});
    const Eigen::Vector3d& o = hierarchy_.origin;
    nodes_.push_back({{"mesh", index}, {"name", mesh_name}, {"translation", {o.x(), o.y(), o.z()}}});
    return index;
  }

  /// Reserves space for the index behind all arrays, zeros for now, because the index contains the size of the file.
  void reserve_index() {
    if (meshes_.size() > AssetIndex::most_meshes) return;
    const std::vector<std::array<char, index_element_size>> zeros(index_size(meshes_.size()) / index_element_size);
    add_section(zeros, SectionKind::cage, index_name);
  }

  AssetIndex make_index(std::size_t file_size) const {
    AssetIndex index;
    index.file_size = static_cast<std::uint32_t>(file_size);
    index.origin = hierarchy_.origin;
    index.fine_error = hierarchy_.fine_error;
    index.solid = hierarchy_.solid;
    index.has_fine = hierarchy_.fine.triangles.rows() > 0;
    index.meshes.resize(stored_.size() / mesh_sections.size());
    const std::size_t place = stored_.back().place;
    for (std::size_t i = 0; i + 1 < stored_.size(); ++i) {
      const StoredArray& array = stored_[i];
      index.meshes[i / mesh_sections.size()][i % mesh_sections.size()] = {
          static_cast<std::uint32_t>(place - array.place), static_cast<std::uint32_t>(array.size), array.hash};
    }
    return index;
  }

  /// Appends an array at the next aligned offset; returns the index of its buffer view. Target 0 stands for data that
  /// glTF does not know.
  template <class T>
  std::size_t add_section(const std::vector<T>& elements, SectionKind kind, const std::string& section_name,
                          int target = 0) {
    const std::span<const std::byte> bytes = std::as_bytes(std::span(elements));
    const std::size_t index = views_.size();
    const Hash hash = hash_bytes(bytes);
    stored_.push_back({bin_.size(), bytes.size(), hash});
    views_.push_back({{"buffer", 0}, {"byteLength", bytes.size()}, {"byteOffset", bin_.size()}});
    if (target != 0) views_.back()["target"] = target;
    sections_.push_back({{"bufferView", index},
                         {"element_size", sizeof(T)},
                         {"hash", to_string(hash)},
                         {"kind", name(kind)},
                         {"name", section_name}});
    bin_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    bin_.resize(align_up(bin_.size()), '\0');
    return index;
  }

  void finish_document(const std::string& generator, json extension) {
    json scene_nodes = json::array();
    for (std::size_t i = 0; i < nodes_.size(); ++i) scene_nodes.push_back(i);
    const json cage_material = {
        {"name", "cage"},
        {"alphaMode", "BLEND"},
        {"doubleSided", true},
        {"pbrMetallicRoughness", {{"baseColorFactor", {0.25, 0.5, 0.75, 0.25}}, {"metallicFactor", 0}}}};
    document_ = {{"accessors", std::move(accessors_)},
                 {"asset", {{"generator", generator}, {"version", "2.0"}}},
                 {"bufferViews", std::move(views_)},
                 {"buffers", json::array({{{"byteLength", bin_.size() + seal_size}}})},
                 {"extensions", {{asset_extension, std::move(extension)}}},
                 {"extensionsUsed", json::array({asset_extension})},
                 {"materials", json::array({cage_material})},
                 {"meshes", std::move(meshes_)},
                 {"nodes", std::move(nodes_)},
                 {"scene", 0},
                 {"scenes", json::array({{{"nodes", std::move(scene_nodes)}}})}};
  }

  std::string seal() {
    std::string bytes = glb_head(dump(), bin_.size() + seal_size, file_);
    if (stored_.size() % mesh_sections.size() == 1) {
      // The final hash has as many digits as that of the zeros, so the size of the JSON does not change.
      const std::string index = encode_index(make_index(bytes.size() + bin_.size() + seal_size));
      bin_.replace(stored_.back().place, index.size(), index);
      document_["extensions"][asset_extension]["sections"].back()["hash"] =
          to_string(hash_bytes(std::as_bytes(std::span(index))));
      bytes = glb_head(dump(), bin_.size() + seal_size, file_);
    }
    const std::string head_hash = to_string(hash_bytes(std::as_bytes(std::span(bytes))));
    bytes += bin_;
    bytes += head_hash;
    bytes += to_string(hash_bytes(std::as_bytes(std::span(bytes))));
    return bytes;
  }

  std::string dump() const {
    try {
      return document_.dump();
    } catch (const json::exception& e) {  // thrown for text that is not UTF-8
      throw Error(file_ + ": JSON: " + e.what());
    }
  }

  const CageHierarchy& hierarchy_;
  const std::string& file_;
  struct StoredArray {
    std::size_t place, size;  // in bin_
    Hash hash;
  };
  std::string bin_;
  std::vector<StoredArray> stored_;
  json views_ = json::array(), accessors_ = json::array(), meshes_ = json::array(), nodes_ = json::array();
  json sections_ = json::array(), document_;
};

}  // namespace

std::string encode_asset(const CageHierarchy& hierarchy, const std::string& generator, const std::string& file) {
  return Encoder(hierarchy, file).encode(generator);
}

std::string encode_asset(const CageHierarchy& hierarchy, const std::string& file) {
  const Version v = version();
  const std::string generator =
      "Encage " + std::to_string(v.major) + "." + std::to_string(v.minor) + "." + std::to_string(v.patch);
  return encode_asset(hierarchy, generator, file);
}

void write_asset(const std::filesystem::path& file, const CageHierarchy& hierarchy) {
  write_atomically(file, encode_asset(hierarchy, file.string()));
}

}  // namespace encage
