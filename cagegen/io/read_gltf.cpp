// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/gltf_document.h"
#include "cagegen/io/gltf_draco.h"
#include "cagegen/io/mesh_file.h"

#include <encage/error.h>

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace encage::io {
namespace {

using Components = GltfDocument::Components;

/// Kinds of primitives, with the numbers that files use.
enum class Mode { points, lines, line_loop, line_strip, triangles, triangle_strip, triangle_fan };

/// How far joints may move vertices, in diagonals of the mesh, that still stand where they were modelled: inverse bind
/// matrices are float32, and the joints' transforms that they undo are rounded otherwise.
constexpr double bind_pose_rounding = 1e-5;

/// A mesh before its node places it.
struct LocalMesh {
  std::vector<double> coordinates;
  std::vector<std::int32_t> corners;  ///< three for each triangle
  bool mirrored = false;              ///< its joints mirror it
};

struct Skin {
  std::vector<Eigen::Affine3d> joints;  ///< from the pose in which the mesh was bound to the scene
  bool mirrors = false;                 ///< every joint does
};

/// `count` numbers of a member, or none if it is absent.
std::optional<std::vector<double>> find_numbers(const JsonNode& node, const char* member, std::int64_t count) {
  const std::optional<JsonNode> found = node.find(member);
  if (!found) return std::nullopt;
  if (found->size() != count) {
    found->fail("has " + std::to_string(found->size()) + " numbers, needs " + std::to_string(count));
  }
  std::vector<double> numbers;
  for (std::int64_t i = 0; i < count; ++i) numbers.push_back(found->at(i).number());
  return numbers;
}

/// The rotation of a quaternion x, y, z, w; no value if it has no direction.
std::optional<Eigen::Quaterniond> rotation_of(const double* q) {
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!(rotation.norm() > 0)) return std::nullopt;
  return rotation.normalized();
}

Eigen::Affine3d transform_of(const JsonNode& node) {
  Eigen::Affine3d result = Eigen::Affine3d::Identity();
  if (const auto matrix = find_numbers(node, "matrix", 16)) {
    result.matrix() = Eigen::Map<const Eigen::Matrix4d>(matrix->data());  // column-major as well
    if (result.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) node.fail("matrix is not affine");
    return result;
  }
  if (const auto translation = find_numbers(node, "translation", 3)) {
    result.translate(Eigen::Map<const Eigen::Vector3d>(translation->data()));
  }
  if (const auto quaternion = find_numbers(node, "rotation", 4)) {
    const std::optional<Eigen::Quaterniond> rotation = rotation_of(quaternion->data());
    if (!rotation) node.fail("rotation is not a unit quaternion");
    result.rotate(*rotation);
  }
  if (const auto scale = find_numbers(node, "scale", 3)) result.scale(Eigen::Map<const Eigen::Vector3d>(scale->data()));
  return result;
}

bool is_hidden(const JsonNode& node) {
  const std::optional<JsonNode> visibility = find_extension(node, "KHR_node_visibility");
  const std::optional<JsonNode> visible = visibility ? visibility->find("visible") : std::nullopt;
  return visible && !visible->boolean();
}

/// Collects the triangles of a scene.
class GltfScene {
 public:
  GltfScene(const std::filesystem::path& file, std::string_view bytes) : file_(file), document_(file, bytes) {}

  Soup read() {
    visited_.assign(static_cast<std::size_t>(document_.count("nodes")), false);
    for (const std::int64_t root : roots()) read_tree(root);
    const std::string left_out = skipped();
    if (soup_.polygon_count() == 0) {
      fail(file_, "no triangles in the scene" + (left_out.empty() ? "" : " (" + left_out + ")"));
    }
    if (!left_out.empty()) soup_.notes.push_back(left_out);
    if (const std::string pose = default_pose(); !pose.empty()) soup_.notes.push_back(pose);
    return std::move(soup_);
  }

 private:
  // ---- The scene's nodes ---------------------------------------------------

  /// The nodes that a member lists.
  std::vector<std::int64_t> listed_nodes(const JsonNode& element, const char* member) const {
    std::vector<std::int64_t> nodes;
    const std::optional<JsonNode> list = element.find(member);
    for (std::int64_t i = 0; list && i < list->size(); ++i) {
      const JsonNode reference = list->at(i);
      document_.element("nodes", "node", reference);  // exists
      nodes.push_back(reference.integer());
    }
    return nodes;
  }

  /// Of the default scene, else of the first, else all nodes without a parent.
  std::vector<std::int64_t> roots() {
    const std::int64_t scenes = document_.count("scenes");
    const std::optional<JsonNode> chosen = document_.root().find("scene");
    if (scenes > 0) {
      const JsonNode scene =
          chosen ? document_.element("scenes", "scene", *chosen) : document_.element("scenes", "scene", 0);
      return listed_nodes(scene, "nodes");
    }
    find_parents();
    std::vector<std::int64_t> result;
    for (std::size_t n = 0; n < parents_.size(); ++n) {
      if (parents_[n] == no_parent) result.push_back(static_cast<std::int64_t>(n));
    }
    return result;
  }

  struct Visit {
    std::int64_t node;
    Eigen::Affine3d parent;  ///< transform to the scene
  };

  /// A node and all below it, depth first. Not recursive: files may nest nodes as deep as they like.
  void read_tree(std::int64_t root) {
    std::vector<Visit> pending{{root, Eigen::Affine3d::Identity()}};
    while (!pending.empty()) {
      const Visit visit = pending.back();
      pending.pop_back();
      read_node(visit, pending);
    }
  }

  /// Reads the node itself, and leaves its children to be read, the first one next.
  void read_node(const Visit& visit, std::vector<Visit>& pending) {
    const JsonNode node = document_.element("nodes", "node", visit.node);
    const auto number = static_cast<std::size_t>(visit.node);
    if (visited_[number]) node.fail("has more than one parent");
    visited_[number] = true;
    if (is_hidden(node)) {
      ++hidden_nodes_;
      return;
    }
    const Eigen::Affine3d global = visit.parent * transform_of(node);
    if (const std::optional<JsonNode> mesh = node.find("mesh")) place_mesh(node, *mesh, global);
    const std::vector<std::int64_t> children = listed_nodes(node, "children");
    for (auto child = children.rbegin(); child != children.rend(); ++child) pending.push_back({*child, global});
  }

  void place_mesh(const JsonNode& node, const JsonNode& reference, const Eigen::Affine3d& global) {
    const std::optional<JsonNode> skin = node.find("skin");
    const std::optional<JsonNode> instancing = find_extension(node, "EXT_mesh_gpu_instancing");
    if (skin && instancing) node.fail("EXT_mesh_gpu_instancing does not say where instances of a skinned mesh are");
    // The joints of a skinned mesh place it, and not its node.
    if (skin) return add(node, local_mesh(node, reference), Eigen::Affine3d::Identity());
    if (!instancing) return add(node, local_mesh(node, reference), global);
    const std::vector<Eigen::Affine3d> places = instances(*instancing);
    // A mesh that is nowhere is not kept either: a file could have any number of them.
    if (places.empty()) return;
    const LocalMesh& mesh = local_mesh(node, reference);
    for (const Eigen::Affine3d& place : places) add(node, mesh, global * place);
  }

  std::vector<Eigen::Affine3d> instances(const JsonNode& instancing) {
    const JsonNode attributes = instancing.at("attributes");
    std::optional<std::int64_t> count;
    for (const auto& [name, value] : attributes.object().items()) {
      const std::int64_t here = document_.accessor(attributes.at(name.c_str())).at("count").integer();
      if (count && *count != here) {
        attributes.at(name.c_str())
            .fail("has " + std::to_string(here) + " elements, another attribute " + std::to_string(*count));
      }
      count = here;
    }
    if (!count) attributes.fail("has no attribute, so the number of instances is unknown");
    const auto find = [&](const char* name, const char* type, Components components) {
      const std::optional<JsonNode> reference = attributes.find(name);
      return reference ? document_.numbers(*reference, type, components) : std::vector<double>();
    };
    const std::vector<double> translations = find("TRANSLATION", "VEC3", Components::any);
    const std::vector<double> rotations = find("ROTATION", "VEC4", Components::normalized);
    const std::vector<double> scales = find("SCALE", "VEC3", Components::any);
    // Those of meshes without triangles count as well: any number of nodes may have them.
    if (*count > document_.plausible_size() - instance_count_) {
      attributes.fail("a file of this size cannot mean " + std::to_string(*count) +
                      (instance_count_ > 0 ? " more instances" : " instances"));
    }
    instance_count_ += *count;
    std::vector<Eigen::Affine3d> result(static_cast<std::size_t>(*count), Eigen::Affine3d::Identity());
    for (std::size_t i = 0; i < result.size(); ++i) {
      if (!translations.empty()) result[i].translate(Eigen::Map<const Eigen::Vector3d>(translations.data() + 3 * i));
      if (!rotations.empty()) {
        const std::optional<Eigen::Quaterniond> rotation = rotation_of(rotations.data() + 4 * i);
        if (!rotation) attributes.at("ROTATION").fail("instance " + std::to_string(i) + " has no unit quaternion");
        result[i].rotate(*rotation);
      }
      if (!scales.empty()) result[i].scale(Eigen::Map<const Eigen::Vector3d>(scales.data() + 3 * i));
    }
    return result;
  }

  /// Three coordinates a vertex, three corners a triangle.
  void require_plausible(const JsonNode& node, std::size_t coordinates, std::size_t corners) const {
    if (static_cast<std::int64_t>(std::max(coordinates, corners) / 3) > document_.plausible_size()) {
      node.fail("the scene unfolds to more triangles than a file of this size can mean");
    }
  }

  void add(const JsonNode& node, const LocalMesh& mesh, const Eigen::Affine3d& to_scene) {
    const std::int64_t base = soup_.vertex_count();
    require_plausible(node, mesh.coordinates.size() + soup_.coordinates.size(),
                      mesh.corners.size() + soup_.corners.size());
    for (std::size_t i = 0; i < mesh.coordinates.size(); i += 3) {
      const Eigen::Vector3d local(mesh.coordinates[i], mesh.coordinates[i + 1], mesh.coordinates[i + 2]);
      const Eigen::Vector3d point = to_scene * local;
      soup_.coordinates.insert(soup_.coordinates.end(), point.data(), point.data() + 3);
    }
    // A mirroring transform turns the winding (glTF 2.0, section 3.7.2.1).
    const bool mirrored = mesh.mirrored != (to_scene.linear().determinant() < 0);
    for (std::size_t i = 0; i < mesh.corners.size(); i += 3) {
      for (const std::size_t k : {std::size_t{0}, std::size_t{mirrored ? 2u : 1u}, std::size_t{mirrored ? 1u : 2u}}) {
        soup_.corners.push_back(static_cast<std::int32_t>(base + mesh.corners[i + k]));
      }
      soup_.end_polygon();
    }
  }

  // ---- Meshes --------------------------------------------------------------

  /// The mesh in the pose that the node gives it. The result lives until the next call.
  const LocalMesh& local_mesh(const JsonNode& node, const JsonNode& reference) {
    const JsonNode mesh = document_.element("meshes", "mesh", reference);
    const std::int64_t number = reference.integer();
    const std::optional<JsonNode> own = node.find("weights");
    const std::optional<JsonNode> skin = node.find("skin");
    if (skin) skinned_meshes_.insert(number);
    // Many nodes may share a mesh in its own pose.
    const bool shared = !own && !skin;
    if (shared) {
      if (const auto known = meshes_.find(number); known != meshes_.end()) return known->second;
    }
    const std::optional<JsonNode> weights = own ? own : mesh.find("weights");
    std::vector<double> numbers;
    for (std::int64_t i = 0; weights && i < weights->size(); ++i) numbers.push_back(weights->at(i).number());
    LocalMesh result = MeshReader(*this, mesh, number, numbers, skin ? &find_skin(*skin) : nullptr).read();
    if (shared) return meshes_.emplace(number, std::move(result)).first->second;
    last_mesh_ = std::move(result);
    return last_mesh_;
  }

  /// Reads the primitives of one mesh.
  class MeshReader {
   public:
    MeshReader(GltfScene& scene, const JsonNode& mesh, std::int64_t number, const std::vector<double>& weights,
               const Skin* skin)
        : scene_(scene),
          document_(scene.document_),
          mesh_(mesh),
          number_(number),
          weights_(weights),
          skin_(skin),
          is_first_(scene.counted_meshes_.insert(number).second) {}

    LocalMesh read() {
      const JsonNode primitives = mesh_.at("primitives");
      for (std::int64_t p = 0; p < primitives.size(); ++p) {
        read_primitive(JsonNode(primitives.at(p).object(), scene_.file_.string() + ": mesh " + std::to_string(number_) +
                                                               ", primitive " + std::to_string(p)));
      }
      if (skin_ != nullptr && joints_move()) {
        result_.coordinates = std::move(skinned_);
        result_.mirrored = skin_->mirrors;
      }
      return std::move(result_);
    }

   private:
    void read_primitive(const JsonNode& primitive) {
      const std::optional<JsonNode> mode_node = primitive.find("mode");
      const Mode mode = mode_node ? static_cast<Mode>(mode_node->integer(0, 6)) : Mode::triangles;
      const std::optional<JsonNode> attributes = primitive.find("attributes");
      const std::optional<JsonNode> position = attributes ? attributes->find("POSITION") : std::nullopt;
      const bool flat = mode >= Mode::triangles;
      if (!flat || !position) {
        if (is_first_) ++(flat ? scene_.without_positions_ : mode == Mode::points ? scene_.points_ : scene_.lines_);
        return;
      }
      if (primitive.find("targets")) scene_.morphed_meshes_.insert(number_);
      const std::optional<DracoMesh> draco = decompress(primitive, *position, mode);
      // Primitives often share their vertices.
      const auto [known, is_new] =
          vertices_.try_emplace(vertex_sources(primitive, draco.has_value()), Vertices{vertex_count(), 0});
      if (is_new) known->second.count = add_vertices(primitive, draco);
      add_triangles(primitive, draco, draco ? Mode::triangles : mode, known->second);
      scene_.require_plausible(primitive, result_.coordinates.size(), result_.corners.size());
    }

    struct Vertices {
      std::int64_t first;
      std::int64_t count;
    };

    std::int64_t vertex_count() const { return static_cast<std::int64_t>(result_.coordinates.size() / 3); }

    /// The references that the vertices of a primitive depend on, -1 where there is none.
    std::vector<std::int64_t> vertex_sources(const JsonNode& primitive, bool compressed) const {
      const JsonNode attributes = primitive.at("attributes");
      std::vector<std::int64_t> sources;
      const auto add = [&](const std::optional<JsonNode>& source) {
        sources.push_back(source ? source->integer() : -1);
      };
      add(attributes.find("POSITION"));
      add(compressed ? find_extension(primitive, draco_extension)->find("bufferView") : std::nullopt);
      for (std::size_t t = 0; t < weights_.size(); ++t) add(target(primitive, t));
      for (int set = 0; skin_ != nullptr && has_joints(primitive, set); ++set) {
        add(attributes.find(name("JOINTS_", set).c_str()));
        add(attributes.find(name("WEIGHTS_", set).c_str()));
      }
      return sources;
    }

    static std::string name(const char* attribute, int set) { return attribute + std::to_string(set); }
    static bool has_joints(const JsonNode& primitive, int set) {
      const JsonNode attributes = primitive.at("attributes");
      return attributes.find(name("JOINTS_", set).c_str()) && attributes.find(name("WEIGHTS_", set).c_str());
    }

    /// The displacements of a morph target that has a weight.
    std::optional<JsonNode> target(const JsonNode& primitive, std::size_t number) const {
      if (weights_[number] == 0) return std::nullopt;
      const std::optional<JsonNode> targets = primitive.find("targets");
      if (!targets) return std::nullopt;
      if (targets->size() != static_cast<std::int64_t>(weights_.size())) {
        primitive.fail("has " + std::to_string(targets->size()) + " morph targets, but there are " +
                       std::to_string(weights_.size()) + " weights");
      }
      return targets->at(static_cast<std::int64_t>(number)).find("POSITION");
    }

    /// What Draco says has no place.
    template <typename Use>
    static auto at_place(const JsonNode& primitive, const Use& use) {
      try {
        return use();
      } catch (const DracoError& error) {
        primitive.fail(error.what());
      }
    }

    std::optional<DracoMesh> decompress(const JsonNode& primitive, const JsonNode& position, Mode mode) const {
      const std::optional<JsonNode> compressed = find_extension(primitive, draco_extension);
      const JsonNode accessor = document_.accessor(position);
      const bool plain = accessor.find("bufferView") || accessor.find("sparse");
      // A file that merely uses the extension has the plain numbers too.
      if (compressed && (!plain || document_.requires_extension(draco_extension))) {
        if (mode == Mode::triangle_fan) primitive.fail(std::string(draco_extension) + " has no triangle fans");
        return at_place(primitive, [&] { return DracoMesh(document_.view(compressed->at("bufferView"))); });
      }
      if (!plain) {
        position.fail("accessor " + std::to_string(position.integer()) +
                      " has no data: neither a buffer view nor sparse values");
      }
      return std::nullopt;
    }

    /// The numbers of an attribute, from Draco's data if that has it.
    std::vector<double> attribute(const JsonNode& primitive, const std::optional<DracoMesh>& draco,
                                  const std::string& attribute, const char* type, int width,
                                  Components components) const {
      const JsonNode reference = primitive.at("attributes").at(attribute.c_str());
      if (draco) {
        if (const auto id = find_extension(primitive, draco_extension)->at("attributes").find(attribute.c_str())) {
          const std::optional<JsonNode> normalized = document_.accessor(reference).find("normalized");
          return at_place(primitive, [&] {
            return draco->attribute(id->integer(0, UINT32_MAX), width, normalized && normalized->boolean());
          });
        }
      }
      return document_.numbers(reference, type, components);
    }

    /// Returns their number.
    std::int64_t add_vertices(const JsonNode& primitive, const std::optional<DracoMesh>& draco) {
      std::vector<double> positions = attribute(primitive, draco, "POSITION", "VEC3", 3, Components::any);
      const auto count = static_cast<std::int64_t>(positions.size() / 3);
      for (std::size_t t = 0; t < weights_.size(); ++t) {
        const std::optional<JsonNode> moved = target(primitive, t);
        if (!moved) continue;
        const std::vector<double> displacements = document_.numbers(*moved, "VEC3", Components::any);
        if (displacements.size() != positions.size()) {
          moved->fail("has " + std::to_string(displacements.size() / 3) + " elements for " + std::to_string(count) +
                      " vertices");
        }
        for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += weights_[t] * displacements[i];
      }
      for (std::size_t i = 0; i < positions.size(); ++i) {
        if (!std::isfinite(positions[i])) primitive.fail("vertex " + std::to_string(i / 3) + " is not finite");
      }
      result_.coordinates.insert(result_.coordinates.end(), positions.begin(), positions.end());
      if (skin_ != nullptr) add_skinned(primitive, draco, positions);
      return count;
    }

    void add_skinned(const JsonNode& primitive, const std::optional<DracoMesh>& draco,
                     const std::vector<double>& positions) {
      const std::size_t count = positions.size() / 3;
      std::vector<double> sums(positions.size(), 0), totals(count, 0);
      for (int set = 0; has_joints(primitive, set); ++set) {
        // Read as numbers, because Draco gives them so; they are small and exact.
        const std::vector<double> joints =
            attribute(primitive, draco, name("JOINTS_", set), "VEC4", 4, Components::any);
        const std::vector<double> weights =
            attribute(primitive, draco, name("WEIGHTS_", set), "VEC4", 4, Components::normalized);
        if (joints.size() != 4 * count || weights.size() != 4 * count) {
          primitive.fail(name("JOINTS_", set) + " and " + name("WEIGHTS_", set) +
                         " have not as many elements as there are vertices");
        }
        for (std::size_t i = 0; i < joints.size(); ++i) {
          if (weights[i] == 0) continue;
          const std::size_t v = i / 4;
          const bool exists = joints[i] >= 0 && joints[i] < static_cast<double>(skin_->joints.size()) &&
                              joints[i] == std::floor(joints[i]);
          if (!exists) {
            primitive.fail("vertex " + std::to_string(v) + " follows a joint that its skin of " +
                           std::to_string(skin_->joints.size()) + " joints does not have");
          }
          const Eigen::Affine3d& joint = skin_->joints[static_cast<std::size_t>(joints[i])];
          Eigen::Map<Eigen::Vector3d>(sums.data() + 3 * v) +=
              weights[i] * (joint * Eigen::Map<const Eigen::Vector3d>(positions.data() + 3 * v));
          totals[v] += weights[i];
        }
      }
      for (std::size_t v = 0; v < count; ++v) {
        for (std::size_t k = 3 * v; k < 3 * v + 3; ++k) {
          // Weights add up to one but for rounding. A vertex without weights follows no joint.
          skinned_.push_back(totals[v] == 0 ? positions[k] : sums[k] / totals[v]);
          if (!std::isfinite(skinned_.back())) {
            primitive.fail("vertex " + std::to_string(v) + " is not finite in its skin's pose");
          }
        }
      }
    }

    /// Whether the pose is another one than that in which the mesh was bound.
    bool joints_move() const {
      Eigen::AlignedBox3d box;
      double farthest = 0;
      for (std::size_t i = 0; i < skinned_.size(); i += 3) {
        const Eigen::Map<const Eigen::Vector3d> bound(result_.coordinates.data() + i), moved(skinned_.data() + i);
        box.extend(Eigen::Vector3d(bound));
        farthest = std::max(farthest, (moved - bound).norm());
      }
      return !skinned_.empty() && farthest > bind_pose_rounding * box.diagonal().norm();
    }

    void add_triangles(const JsonNode& primitive, const std::optional<DracoMesh>& draco, Mode mode,
                       const Vertices& vertices) {
      std::vector<std::int64_t> indices;
      const std::optional<JsonNode> indexed = primitive.find("indices");
      if (draco) {
        indices = at_place(primitive, [&] { return draco->corners(); });
      } else if (indexed) {
        const JsonNode accessor = document_.accessor(*indexed);
        if (!accessor.find("bufferView") && !accessor.find("sparse")) {
          indexed->fail("accessor " + std::to_string(indexed->integer()) +
                        " has no data: neither a buffer view nor sparse values");
        }
        indices = document_.integers(*indexed, "SCALAR");
      } else {
        for (std::int64_t i = 0; i < vertices.count; ++i) indices.push_back(i);
      }
      for (const std::int64_t index : indices) {
        if (index >= vertices.count) {
          primitive.fail("index " + std::to_string(index) + " is out of range (" + std::to_string(vertices.count) +
                         " vertices)");
        }
      }
      const std::size_t step = mode == Mode::triangles ? 3 : 1;
      if (step == 3 && indices.size() % 3 != 0) {
        primitive.fail(std::to_string(indices.size()) + (indexed ? " indices" : " vertices") +
                       " are no whole number of triangles");
      }
      for (std::size_t i = 0; i + 2 < indices.size(); i += step) {
        std::size_t corners[3] = {i, i + 1, i + 2};
        if (mode == Mode::triangle_strip && i % 2 == 1) std::swap(corners[1], corners[2]);
        if (mode == Mode::triangle_fan) corners[0] = 0;
        for (const std::size_t corner : corners) {
          result_.corners.push_back(static_cast<std::int32_t>(vertices.first + indices[corner]));
        }
      }
    }

    GltfScene& scene_;
    GltfDocument& document_;
    const JsonNode& mesh_;
    std::int64_t number_;
    const std::vector<double>& weights_;  ///< of the morph targets
    const Skin* skin_;
    bool is_first_;  ///< to read this mesh
    std::map<std::vector<std::int64_t>, Vertices> vertices_;
    LocalMesh result_;
    std::vector<double> skinned_;  ///< the vertices where the joints put them
  };

  // ---- Skins ---------------------------------------------------------------

  const Skin& find_skin(const JsonNode& reference) {
    const JsonNode node = document_.element("skins", "skin", reference);
    const auto [known, is_new] = skins_.try_emplace(reference.integer());
    if (is_new) known->second = read_skin(node);
    return known->second;
  }

  Skin read_skin(const JsonNode& node) {
    node.at("joints").size();
    const std::vector<std::int64_t> joints = listed_nodes(node, "joints");
    const std::optional<JsonNode> inverse = node.find("inverseBindMatrices");
    std::vector<double> matrices;
    if (inverse) {
      matrices = document_.numbers(*inverse, "MAT4", Components::floats);
      if (matrices.size() / 16 < joints.size()) {
        inverse->fail("has " + std::to_string(matrices.size() / 16) + " matrices for " + std::to_string(joints.size()) +
                      " joints");
      }
    }
    Skin skin;
    skin.mirrors = !joints.empty();
    for (std::size_t j = 0; j < joints.size(); ++j) {
      Eigen::Affine3d joint = global_transform(joints[j]);
      if (inverse) {
        const Eigen::Map<const Eigen::Matrix4d> matrix(matrices.data() + 16 * j);
        // The last row is rounded in some files.
        constexpr double rounding = 1e-4;
        if (!((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < rounding)) {
          inverse->fail("matrix " + std::to_string(j) + " is not affine");
        }
        Eigen::Affine3d from_bound = Eigen::Affine3d::Identity();
        from_bound.affine() = matrix.topRows<3>();
        joint = joint * from_bound;
      }
      skin.mirrors = skin.mirrors && joint.linear().determinant() < 0;
      skin.joints.push_back(joint);
    }
    return skin;
  }

  static constexpr std::int64_t no_parent = -1, two_parents = -2;

  void find_parents() {
    if (!parents_.empty()) return;
    parents_.assign(visited_.size(), no_parent);
    for (std::int64_t n = 0; n < static_cast<std::int64_t>(parents_.size()); ++n) {
      for (const std::int64_t child : listed_nodes(document_.element("nodes", "node", n), "children")) {
        std::int64_t& parent = parents_[static_cast<std::size_t>(child)];
        parent = parent == no_parent ? n : two_parents;
      }
    }
  }

  /// Of a node that may be outside the scene.
  const Eigen::Affine3d& global_transform(std::int64_t number) {
    find_parents();
    std::vector<std::int64_t> path;  // up to where the transform is known
    for (std::int64_t n = number; n != no_parent && !globals_.contains(n); n = parents_[static_cast<std::size_t>(n)]) {
      const JsonNode node = document_.element("nodes", "node", n);
      if (parents_[static_cast<std::size_t>(n)] == two_parents) node.fail("has more than one parent");
      if (path.size() == parents_.size()) node.fail("is below itself");
      path.push_back(n);
    }
    for (auto n = path.rbegin(); n != path.rend(); ++n) {
      const std::int64_t parent = parents_[static_cast<std::size_t>(*n)];
      const Eigen::Affine3d local = transform_of(document_.element("nodes", "node", *n));
      globals_.emplace(*n, parent == no_parent ? local : globals_.at(parent) * local);
    }
    return globals_.at(number);
  }

  // ---- Notes ---------------------------------------------------------------

  /// "A, B" of what there is any of.
  static std::string listed(std::initializer_list<std::pair<std::int64_t, std::array<const char*, 2>>> counts) {
    std::string list;
    for (const auto& [count, words] : counts) {
      if (count > 0) list += (list.empty() ? "" : ", ") + std::to_string(count) + ' ' + words[count == 1 ? 0 : 1];
    }
    return list;
  }

  std::string skipped() const {
    const std::string list =
        listed({{points_, {"primitive of points", "primitives of points"}},
                {lines_, {"primitive of lines", "primitives of lines"}},
                {without_positions_, {"primitive without positions", "primitives without positions"}},
                {hidden_nodes_, {"hidden node", "hidden nodes"}},
                {document_.count("scenes") - 1, {"other scene", "other scenes"}}});
    return list.empty() ? list : "skipped: " + list;
  }

  std::string default_pose() const {
    const std::string list = listed(
        {{static_cast<std::int64_t>(morphed_meshes_.size()), {"mesh with morph targets", "meshes with morph targets"}},
         {static_cast<std::int64_t>(skinned_meshes_.size()), {"mesh with a skin", "meshes with skins"}},
         {document_.count("animations"), {"animation", "animations"}}});
    return list.empty() ? list : "only the default pose is read: " + list;
  }

  const std::filesystem::path& file_;
  GltfDocument document_;
  std::vector<bool> visited_;          ///< nodes form trees (glTF 2.0, section 3.5.1)
  std::vector<std::int64_t> parents_;  ///< of the nodes; empty until they are asked for
  std::map<std::int64_t, Eigen::Affine3d> globals_;
  std::map<std::int64_t, Skin> skins_;
  std::map<std::int64_t, LocalMesh> meshes_;
  LocalMesh last_mesh_;
  std::set<std::int64_t> counted_meshes_, morphed_meshes_, skinned_meshes_;
  std::int64_t instance_count_ = 0;  ///< of all nodes
  std::int64_t points_ = 0, lines_ = 0, without_positions_ = 0, hidden_nodes_ = 0;
  Soup soup_;
};

}  // namespace

Soup read_gltf(const std::filesystem::path& file, std::string_view bytes) { return GltfScene(file, bytes).read(); }

}  // namespace encage::io
