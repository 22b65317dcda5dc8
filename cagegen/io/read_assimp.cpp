// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/read_assimp.h"

#include "cagegen/io/text_scanner.h"

#ifdef ENCAGE_WITH_ASSIMP
#include <assimp/DefaultIOSystem.h>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/scene.h>
#endif

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace encage::io {

#ifdef ENCAGE_WITH_ASSIMP

namespace {

constexpr std::array<std::string_view, 6> own_formats = {"obj", "ply", "stl", "off", "gltf", "glb"};

/// The file from memory, whatever else it refers to from the disk.
class FileInMemory : public Assimp::DefaultIOSystem {
 public:
  FileInMemory(std::string name, std::string_view bytes) : name_(std::move(name)), bytes_(bytes) {}

  bool Exists(const char* name) const override { return name_ == name || DefaultIOSystem::Exists(name); }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (name_ != name) return DefaultIOSystem::Open(name, mode);
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()), bytes_.size());
  }

 private:
  std::string name_;
  std::string_view bytes_;
};

/// Keeps the first error that Assimp reports while it lives; Assimp's logger is one for the process.
class AssimpErrors : public Assimp::LogStream {
 public:
  AssimpErrors() {
    Assimp::DefaultLogger::create(nullptr, Assimp::Logger::NORMAL, 0);
    Assimp::DefaultLogger::get()->attachStream(this, Assimp::Logger::Err);
  }
  ~AssimpErrors() override {
    Assimp::DefaultLogger::get()->detachStream(this, Assimp::Logger::Err);
    Assimp::DefaultLogger::kill();
  }
  AssimpErrors(const AssimpErrors&) = delete;
  AssimpErrors& operator=(const AssimpErrors&) = delete;

  void write(const char* message) override {
    if (first_.empty()) first_ = message;
    while (!first_.empty() && first_.back() == '\n') first_.pop_back();
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

/// Collects the faces of a scene.
class AssimpScene {
 public:
  AssimpScene(const std::filesystem::path& file, const aiScene& scene) : file_(file), scene_(scene) {}

  Soup read() {
    std::vector<Visit> pending;
    if (scene_.mRootNode != nullptr) pending.push_back({scene_.mRootNode, Eigen::Affine3d::Identity()});
    while (!pending.empty()) {
      const Visit visit = pending.back();
      pending.pop_back();
      const Eigen::Affine3d to_scene = visit.parent * transform(*visit.node);
      for (unsigned int m = 0; m < visit.node->mNumMeshes; ++m) add_mesh(visit.node->mMeshes[m], to_scene);
      for (unsigned int c = visit.node->mNumChildren; c-- > 0;) pending.push_back({visit.node->mChildren[c], to_scene});
    }
    add_notes();
    return std::move(soup_);
  }

 private:
  struct Visit {
    const aiNode* node;
    Eigen::Affine3d parent;
  };

  static Eigen::Affine3d transform(const aiNode& node) {
    const aiMatrix4x4& m = node.mTransformation;
    Eigen::Affine3d result = Eigen::Affine3d::Identity();
    for (unsigned int row = 0; row < 3; ++row) {
      for (unsigned int column = 0; column < 4; ++column) result(row, column) = m[row][column];
    }
    return result;
  }

  void add_mesh(unsigned int number, const Eigen::Affine3d& to_scene) {
    if (number >= scene_.mNumMeshes) fail(file_, "mesh", number, "does not exist");
    const aiMesh& mesh = *scene_.mMeshes[number];
    skinned_ |= mesh.HasBones();
    morphed_ |= mesh.mNumAnimMeshes > 0;
    const std::int64_t base = soup_.vertex_count();
    for (unsigned int v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      const Eigen::Vector3d point = to_scene * Eigen::Vector3d(p.x, p.y, p.z);
      soup_.coordinates.insert(soup_.coordinates.end(), point.data(), point.data() + 3);
    }
    // A mirroring transform turns the winding.
    const bool mirrored = to_scene.linear().determinant() < 0;
    for (unsigned int f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) {
        ++small_faces_;
        continue;
      }
      for (unsigned int c = 0; c < face.mNumIndices; ++c) {
        const unsigned int index = face.mIndices[mirrored ? face.mNumIndices - 1 - c : c];
        if (index >= mesh.mNumVertices) {
          fail(file_, "mesh", number,
               "face " + std::to_string(f) + ": vertex index " + std::to_string(index) + " is out of range (" +
                   std::to_string(mesh.mNumVertices) + " vertices)");
        }
        soup_.corners.push_back(static_cast<std::int32_t>(base + index));
      }
      soup_.end_polygon();
    }
  }

  void add_notes() {
    soup_.notes.emplace_back("read by Assimp: coordinates in float32, split vertices welded");
    if (small_faces_ > 0) {
      soup_.notes.push_back("skipped: " + counted(small_faces_, "point or line", "points and lines"));
    }
    if (skinned_) soup_.notes.emplace_back("skinned meshes are read in their bind pose");
    if (morphed_) soup_.notes.emplace_back("morph targets are left out");
  }

  const std::filesystem::path& file_;
  const aiScene& scene_;
  Soup soup_;
  std::int64_t small_faces_ = 0;
  bool skinned_ = false, morphed_ = false;
};

/// The first line of what Assimp says, without severity and thread in front ("Error, T0: ").
std::string one_line(std::string text) {
  text.resize(std::min(text.find('\n'), text.size()));
  if (text.starts_with("Error,")) text.erase(0, std::min(text.find(": ") + 2, text.size()));
  return text;
}

}  // namespace

std::string assimp_formats() {
  std::string known, list;
  Assimp::Importer().GetExtensionList(known);  // "*.3ds;*.dae;…"
  std::size_t begin = 0;
  while (begin < known.size()) {
    const std::size_t end = std::min(known.find(';', begin), known.size());
    const std::string format = known.substr(begin + 2, end - begin - 2);
    if (std::find(own_formats.begin(), own_formats.end(), format) == own_formats.end()) {
      list += (list.empty() ? "" : " ") + format;
    }
    begin = end + 1;
  }
  return list;
}

std::string more_formats() { return "Assimp reads: " + assimp_formats(); }

bool assimp_reads(const std::string& format) {
  return (' ' + assimp_formats() + ' ').find(' ' + format + ' ') != std::string::npos;
}

Soup read_assimp(const std::filesystem::path& file, std::string_view bytes, const std::string& format) {
  static std::mutex one_at_a_time;  // the logger is the process's
  const std::lock_guard lock(one_at_a_time);
  const AssimpErrors errors;
  Assimp::Importer importer;
  // Numbers and axes stay as they are in the file, and no mesh is made up for a skeleton.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const std::string name = (folder / (file.stem().string() + '.' + format)).string();
  importer.SetIOHandler(new FileInMemory(name, bytes));
  const aiScene* scene = nullptr;
  std::string reason;
  try {
    scene = importer.ReadFile(name, 0);
    if (scene == nullptr) reason = importer.GetErrorString();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& exception) {
    reason = exception.what();
  }
  if (scene == nullptr) fail(file, "Assimp cannot read it: " + one_line(reason));
  Soup soup = AssimpScene(file, *scene).read();
  if (!errors.first().empty()) soup.notes.push_back("Assimp reports: " + one_line(errors.first()));
  if (soup.polygon_count() == 0) return soup;
  if (soup.vertex_count() > std::numeric_limits<std::int32_t>::max()) fail(file, "more than 2^31 - 1 vertices");
  require_finite(file, soup);
  share_vertices(soup);
  return soup;
}

#else

std::string assimp_formats() { return {}; }

std::string more_formats() {
  return "this build of Encage lacks Assimp, which reads many more, such as dae, 3ds, fbx and 3mf; install it (Debian: "
         "libassimp-dev) and build Encage again, or convert the file";
}

bool assimp_reads(const std::string&) { return false; }

Soup read_assimp(const std::filesystem::path& file, std::string_view, const std::string&) {
  fail(file, more_formats());
}

#endif

}  // namespace encage::io
