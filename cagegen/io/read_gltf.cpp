// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "src/asset/json.h"

#include <Eigen/Geometry>
#include <tiny_gltf.h>

#include <cstring>
#include <map>
#include <string>

namespace encage::io {
namespace {

/// The elements of an accessor, not copied: `count` of them, `stride` bytes apart.
struct AccessorView {
  const unsigned char* data = nullptr;
  std::size_t stride = 0;
  std::size_t count = 0;
  int component = 0;
};

template <typename T>
T load(const unsigned char* data) {
  T value;
  std::memcpy(&value, data, sizeof(T));
  return value;
}

/// Collects the triangles of a scene.
class GltfScene {
 public:
  GltfScene(const std::filesystem::path& file, const tinygltf::Model& model) : file_(file), model_(model) {}

  Soup read() {
    visited_.assign(model_.nodes.size(), false);
    for (const int root : roots()) read_tree(root);
    return std::move(soup_);
  }

 private:
  /// Of the default scene, else of the first, else all nodes without a parent.
  std::vector<int> roots() const {
    const std::size_t scene = static_cast<std::size_t>(std::max(model_.defaultScene, 0));
    if (scene < model_.scenes.size()) return model_.scenes[scene].nodes;
    if (!model_.scenes.empty()) fail(file_, "the default scene does not exist");
    std::vector<bool> is_child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes) {
      for (const int child : node.children) {
        if (child >= 0 && child < static_cast<int>(is_child.size())) is_child[child] = true;
      }
    }
    std::vector<int> result;
    for (std::size_t n = 0; n < is_child.size(); ++n) {
      if (!is_child[n]) result.push_back(static_cast<int>(n));
    }
    return result;
  }

  Eigen::Affine3d transform(int number) const {
    const tinygltf::Node& node = model_.nodes[number];
    Eigen::Affine3d result = Eigen::Affine3d::Identity();
    if (node.matrix.size() == 16) {
      result.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());  // column-major as well
      if (result.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) fail(file_, "node", number, "matrix is not affine");
      return result;
    }
    if (node.translation.size() == 3) result.translate(Eigen::Map<const Eigen::Vector3d>(node.translation.data()));
    if (node.rotation.size() == 4) {
      const std::vector<double>& q = node.rotation;
      const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
      if (!(rotation.norm() > 0)) fail(file_, "node", number, "rotation is not a unit quaternion");
      result.rotate(rotation.normalized());
    }
    if (node.scale.size() == 3) result.scale(Eigen::Map<const Eigen::Vector3d>(node.scale.data()));
    return result;
  }

  struct Visit {
    int node;
    Eigen::Affine3d parent;  ///< transform to the scene
  };

  /// A node and all below it, depth first. Not recursive: files may nest nodes as deep as they like.
  void read_tree(int root) {
    std::vector<Visit> pending{{root, Eigen::Affine3d::Identity()}};
    while (!pending.empty()) {
      const Visit visit = pending.back();
      pending.pop_back();
      read_node(visit, pending);
    }
  }

  /// Reads the node itself, and leaves its children to be read, the first one next.
  void read_node(const Visit& visit, std::vector<Visit>& pending) {
    const int number = visit.node;
    if (number < 0 || number >= static_cast<int>(model_.nodes.size())) {
      fail(file_, "node", number, "does not exist");
    }
    if (visited_[number]) fail(file_, "node", number, "has more than one parent");
    visited_[number] = true;
    const tinygltf::Node& node = model_.nodes[number];
    const Eigen::Affine3d global = visit.parent * transform(number);
    // A skinned mesh is placed by its joints, not by its node: it is read in its bind pose.
    if (node.mesh >= 0) add_mesh(node.mesh, node.skin >= 0 ? Eigen::Affine3d::Identity() : global);
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
      pending.push_back({*child, global});
    }
  }

  void add_mesh(int number, const Eigen::Affine3d& to_scene) {
    if (number >= static_cast<int>(model_.meshes.size())) fail(file_, "mesh", number, "does not exist");
    std::map<int, std::int64_t> bases;  // accessor -> first vertex: primitives often share their vertices
    for (const tinygltf::Primitive& primitive : model_.meshes[number].primitives) {
      const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
      const bool triangles =
          mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP || mode == TINYGLTF_MODE_TRIANGLE_FAN;
      if (!triangles) continue;
      const auto position = primitive.attributes.find("POSITION");
      if (position == primitive.attributes.end()) fail(file_, "mesh", number, "a primitive has no positions");
      const auto [base, is_new] = bases.try_emplace(position->second, soup_.vertex_count());
      const AccessorView positions = view(position->second, TINYGLTF_TYPE_VEC3);
      if (positions.component != TINYGLTF_COMPONENT_TYPE_FLOAT) {
        fail(file_, "accessor", position->second, "positions must be float (quantized meshes are not supported)");
      }
      if (is_new) add_vertices(positions, to_scene);
      // A mirroring transform turns the winding (glTF 2.0, section 3.7.2.1).
      add_triangles(primitive.indices, mode, base->second, static_cast<std::int64_t>(positions.count),
                    to_scene.linear().determinant() < 0);
    }
  }

  void add_vertices(const AccessorView& positions, const Eigen::Affine3d& to_scene) {
    for (std::size_t i = 0; i < positions.count; ++i) {
      const unsigned char* const data = positions.data + i * positions.stride;
      const Eigen::Vector3d point =
          to_scene * Eigen::Vector3d(load<float>(data), load<float>(data + 4), load<float>(data + 8));
      soup_.coordinates.insert(soup_.coordinates.end(), point.data(), point.data() + 3);
    }
  }

  void add_triangles(int accessor, int mode, std::int64_t base, std::int64_t vertices, bool mirrored) {
    std::vector<std::int64_t> indices;
    if (accessor >= 0) {
      const AccessorView indexed = view(accessor, TINYGLTF_TYPE_SCALAR);
      for (std::size_t i = 0; i < indexed.count; ++i) {
        indices.push_back(index(indexed, i, accessor));
        if (indices.back() >= vertices) {
          fail(file_, "accessor", accessor,
               "index " + std::to_string(indices.back()) + " is out of range (" + std::to_string(vertices) +
                   " vertices)");
        }
      }
    } else {
      for (std::int64_t i = 0; i < vertices; ++i) indices.push_back(i);
    }
    const std::size_t step = mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1;
    if (step == 3 && indices.size() % 3 != 0) {
      fail(file_, "accessor", accessor, std::to_string(indices.size()) + " indices are no whole number of triangles");
    }
    for (std::size_t i = 0; i + 2 < indices.size(); i += step) {
      std::size_t corners[3] = {i, i + 1, i + 2};
      if (mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1) std::swap(corners[1], corners[2]);
      if (mode == TINYGLTF_MODE_TRIANGLE_FAN) corners[0] = 0;
      if (mirrored) std::swap(corners[1], corners[2]);
      for (const std::size_t corner : corners) soup_.corners.push_back(base + indices[corner]);
      soup_.end_polygon();
    }
  }

  std::int64_t index(const AccessorView& indices, std::size_t i, int accessor) const {
    const unsigned char* const data = indices.data + i * indices.stride;
    switch (indices.component) {
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return *data;
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return load<std::uint16_t>(data);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return load<std::uint32_t>(data);
      default: fail(file_, "accessor", accessor, "indices must be unsigned integers");
    }
  }

  AccessorView view(int number, int type) const {
    if (number < 0 || number >= static_cast<int>(model_.accessors.size())) {
      fail(file_, "accessor", number, "does not exist");
    }
    const tinygltf::Accessor& accessor = model_.accessors[number];
    if (accessor.type != type) fail(file_, "accessor", number, "has the wrong type");
    if (accessor.sparse.isSparse) fail(file_, "accessor", number, "sparse accessors are not supported");
    if (accessor.bufferView < 0 || accessor.bufferView >= static_cast<int>(model_.bufferViews.size())) {
      fail(file_, "accessor", number, "has no buffer view");
    }
    const tinygltf::BufferView& buffer_view = model_.bufferViews[accessor.bufferView];
    if (buffer_view.buffer < 0 || buffer_view.buffer >= static_cast<int>(model_.buffers.size())) {
      fail(file_, "buffer view", accessor.bufferView, "has no buffer");
    }
    const std::vector<unsigned char>& data = model_.buffers[buffer_view.buffer].data;
    const int stride = accessor.ByteStride(buffer_view);
    const std::size_t size = static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(accessor.componentType)) *
                             tinygltf::GetNumComponentsInType(type);
    // Every term is compared before it is used: the numbers come from the file.
    const bool inside =
        stride > 0 && static_cast<std::size_t>(stride) >= size && buffer_view.byteOffset <= data.size() &&
        buffer_view.byteLength <= data.size() - buffer_view.byteOffset &&
        accessor.byteOffset <= buffer_view.byteLength &&
        (accessor.count == 0 || (size <= buffer_view.byteLength - accessor.byteOffset &&
                                 accessor.count - 1 <= (buffer_view.byteLength - accessor.byteOffset - size) / stride));
    if (!inside) fail(file_, "accessor", number, "reaches beyond its buffer");
    return {data.data() + buffer_view.byteOffset + accessor.byteOffset, static_cast<std::size_t>(stride),
            accessor.count, accessor.componentType};
  }

  const std::filesystem::path& file_;
  const tinygltf::Model& model_;
  std::vector<bool> visited_;  ///< nodes form trees (glTF 2.0, section 3.5.1)
  Soup soup_;
};

/// Pictures are of no interest, and need not exist.
bool ignore_image(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

/// The JSON of a file, text or binary, as far as the file holds it.
std::string_view json_of(std::string_view bytes) {
  constexpr std::size_t header = 20;  // of a binary file and its first chunk, which is the JSON
  if (!bytes.starts_with("glTF")) return bytes;
  if (bytes.size() < header) return {};
  return bytes.substr(header, load<std::uint32_t>(reinterpret_cast<const unsigned char*>(bytes.data()) + 12));
}

tinygltf::Model load_model(const std::filesystem::path& file, std::string_view bytes) {
  if (bytes.size() > UINT32_MAX) fail(file, "larger than 4 GiB");
  // The library reads extras recursively.
  if (json_depth(json_of(bytes)) > max_json_depth) {
    fail(file, "JSON nested deeper than " + std::to_string(max_json_depth) + " levels");
  }
  const auto size = static_cast<unsigned int>(bytes.size());
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(ignore_image, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  bool ok = false;
  try {
    ok = bytes.starts_with("glTF")
             ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                           reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
             : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, folder);
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  if (!ok) {
    if (const std::size_t end = error.find('\n'); end != error.npos) error.resize(end);
    fail(file, error.empty() ? "not a glTF file" : error);
  }
  return model;
}

}  // namespace

Soup read_gltf(const std::filesystem::path& file, std::string_view bytes) {
  const tinygltf::Model model = load_model(file, bytes);
  for (const std::string& extension : model.extensionsRequired) {
    // These change where vertices are; others (materials, lights) do not concern us.
    if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression" ||
        extension == "KHR_mesh_quantization" || extension == "EXT_mesh_gpu_instancing") {
      fail(file, "the extension " + extension + " is not supported");
    }
  }
  return GltfScene(file, model).read();
}

}  // namespace encage::io
