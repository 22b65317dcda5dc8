// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/urdf.h"

#include <encage/error.h>

#ifdef ENCAGE_WITH_PUGIXML
#include <pugixml.hpp>
#endif

#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <system_error>
#include <utility>

namespace encage::tool {

namespace fs = std::filesystem;

#ifdef ENCAGE_WITH_PUGIXML

namespace {

bool is_xml_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Three finite numbers, whatever the locale; false for anything else.
bool parse_vector(std::string_view text, Eigen::Vector3d& vector) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto skip_blanks = [&] {
    while (at != end && is_xml_blank(*at)) ++at;
  };
  for (double& value : vector) {
    skip_blanks();
    const auto [stop, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) return false;
    at = stop;
  }
  skip_blanks();
  return at == end;
}

/// Names in a description may be ones that no file can have, as those that are too long: such files are not there.
bool is_there(const fs::path& file) {
  std::error_code none;
  return fs::exists(file, none);
}

/// Names of links may hold anything, and be as long as they like; those of files had better not.
std::string file_name(const std::string& link) {
  constexpr std::size_t most = 200;
  std::string name = link.substr(0, most);
  for (char& c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
                       c == '-' || c == '.' || c == ' ' || static_cast<unsigned char>(c) >= 0x80;
    if (!plain) c = '_';
  }
  return name.empty() || name[0] == '.' ? "_" + name : name;
}

class UrdfReader {
 public:
  UrdfReader(const fs::path& file, std::string_view bytes) : file_(file) {
    const pugi::xml_parse_result result = document_.load_buffer(bytes.data(), bytes.size());
    if (result) return;
    fail("XML, byte " + std::to_string(result.offset) + ": " + result.description());
  }

  Urdf read() {
    const pugi::xml_node robot = document_.document_element();
    if (std::string_view(robot.name()) != "robot") {
      fail("no robot description: the root element is '" + std::string(robot.name()) + "', not 'robot'");
    }
    refuse_macros(robot);
    urdf_.name = robot.attribute("name").value();
    std::set<std::string> links;
    for (const pugi::xml_node link : robot.children("link")) {
      const std::string name = link.attribute("name").value();
      if (name.empty()) fail("a link has no name");
      if (!links.insert(name).second) fail("link '" + name + "': a second one of that name");
      read_link(link, name);
    }
    if (links.empty()) fail("the robot has no links");
    name_bodies();
    add_notes();
    if (urdf_.meshes.empty()) fail("no link has a collision mesh" + (skipped_.empty() ? "" : " (" + skipped_ + ")"));
    return std::move(urdf_);
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const { throw Error(file_.string() + ": " + reason); }
  [[noreturn]] void fail(const std::string& link, const std::string& reason) const {
    fail("link '" + link + "': " + reason);
  }

  void refuse_macros(const pugi::xml_node robot) const {
    for (const pugi::xml_node child : robot.children()) {
      if (std::string_view(child.name()).starts_with("xacro:")) {
        fail("'" + std::string(child.name()) + "': xacro has to be expanded first: xacro FILE > robot.urdf");
      }
    }
  }

  void read_link(const pugi::xml_node link, const std::string& name) {
    for (const pugi::xml_node collision : link.children("collision")) {
      for (const pugi::xml_node shape : collision.child("geometry").children()) {
        if (shape.type() != pugi::node_element) continue;
        if (std::string_view(shape.name()) == "mesh") {
          read_mesh_of(collision, shape, name);
        } else {
          ++primitives_[shape.name()];
        }
      }
    }
  }

  void read_mesh_of(const pugi::xml_node collision, const pugi::xml_node shape, const std::string& link) {
    UrdfMesh mesh{link, {}, shape.attribute("filename").value(), {}, Eigen::Vector3d::Ones(), {}, {}};
    if (mesh.name.empty()) fail(link, "a collision mesh has no filename");
    if (const pugi::xml_attribute scale = shape.attribute("scale")) {
      if (!parse_vector(scale.value(), mesh.scale) || (mesh.scale.array() == 0).any()) {
        fail(link, "scale '" + std::string(scale.value()) + "' is not three numbers other than 0");
      }
    }
    const pugi::xml_node origin = collision.child("origin");
    mesh.origin_xyz = origin_vector(origin.attribute("xyz"), link);
    mesh.origin_rpy = origin_vector(origin.attribute("rpy"), link);
    mesh.file = find(mesh.name, link);
    urdf_.meshes.push_back(std::move(mesh));
  }

  Eigen::Vector3d origin_vector(const pugi::xml_attribute attribute, const std::string& link) const {
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    if (attribute && !parse_vector(attribute.value(), vector)) {
      fail(link, std::string(attribute.name()) + " '" + attribute.value() + "' is not three numbers");
    }
    return vector;
  }

  fs::path find(const std::string& name, const std::string& link) {
    const std::string_view text = name;
    for (const std::string_view scheme : {"package://", "model://"}) {
      if (text.starts_with(scheme)) return find_in_package(text.substr(scheme.size()), name, link);
    }
    const fs::path path = text.starts_with("file://") ? fs::path(text.substr(7)) : fs::path(text);
    if (text.find("://") != text.npos && !text.starts_with("file://")) {
      fail(link, "'" + name + "': only file names, file://, package:// and model:// are followed");
    }
    const fs::path found = path.is_absolute() ? path : folder() / path;
    if (!is_there(found)) fail(link, "mesh '" + name + "' is not there: looked for " + found.string());
    return found;
  }

  /// A package is a folder of its name in that of the description or in one above. Where there is none, the
  /// description's own folder, or one above, may be the package under another name, as downloads are.
  fs::path find_in_package(const std::string_view rest, const std::string& name, const std::string& link) {
    const fs::path inside = fs::path(rest).lexically_normal();
    const std::string package = inside.empty() ? std::string() : inside.begin()->string();
    if (package.empty() || package == "/" || package == "." || package == "..") {
      fail(link, "'" + name + "' names no package");
    }
    std::error_code none;
    const fs::path start = fs::absolute(folder(), none).lexically_normal();
    for (const fs::path& wanted : {inside, inside.lexically_relative(package)}) {
      for (fs::path above = start;; above = above.parent_path()) {
        if (fs::is_regular_file(above / wanted, none)) {
          if (wanted != inside) renamed_[package] = above.string();
          return relative_to_folder(above / wanted);
        }
        if (above == above.parent_path()) break;
      }
    }
    fail(link, "mesh '" + name + "' is not there: no folder from " + start.string() + " upwards holds " +
                   inside.string() + "; put the description into its package, or name the mesh by its path");
  }

  /// As short as the user named the description.
  fs::path relative_to_folder(const fs::path& found) const {
    std::error_code none;
    const fs::path relative = file_.is_absolute() ? fs::path() : fs::proximate(found, none);
    return relative.empty() ? found : relative;
  }

  fs::path folder() const { return file_.has_parent_path() ? file_.parent_path() : fs::path("."); }

  /// Links with several meshes number them.
  void name_bodies() {
    std::map<std::string, int> count, next;
    for (const UrdfMesh& mesh : urdf_.meshes) ++count[mesh.link];
    std::set<std::string> taken;
    for (UrdfMesh& mesh : urdf_.meshes) {
      mesh.body = file_name(mesh.link);
      if (count[mesh.link] > 1) mesh.body += "_" + std::to_string(next[mesh.link]++);
      while (!taken.insert(mesh.body).second) mesh.body += "_";
    }
  }

  void add_notes() {
    for (const auto& [package, where] : renamed_) {
      urdf_.notes.push_back("no folder is called '" + package + "'; its files are taken from " + where);
    }
    int count = 0;
    std::string kinds;
    for (const auto& [kind, number] : primitives_) {
      count += number;
      kinds += (kinds.empty() ? "" : ", ") + kind;
    }
    if (count == 0) return;
    skipped_ =
        std::to_string(count) + (count == 1 ? " collision shape" : " collision shapes") + " without a mesh: " + kinds;
    urdf_.notes.push_back("skipped: " + skipped_);
  }

  const fs::path& file_;
  pugi::xml_document document_;
  Urdf urdf_;
  std::map<std::string, int> primitives_;
  std::map<std::string, std::string> renamed_;  // packages, and folders that serve instead
  std::string skipped_;
};

}  // namespace

bool has_urdf() noexcept { return true; }

Urdf read_urdf(const fs::path& file, std::string_view bytes) { return UrdfReader(file, bytes).read(); }

#else

bool has_urdf() noexcept { return false; }

Urdf read_urdf(const fs::path& file, std::string_view) {
  throw Error(file.string() +
              ": this build of Encage cannot read robot descriptions; install pugixml (Debian: libpugixml-dev) and "
              "build Encage again");
}

#endif

}  // namespace encage::tool
