// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "src/files/atomic_file.h"

#include <encage/bake.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <string>

namespace encage {
namespace {

void append_number(std::string& text, double value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);  // shortest that round-trips
}

void append_vertices(std::string& text, const TriangleMesh& mesh, const char* prefix) {
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    text += prefix;
    for (int k = 0; k < 3; ++k) {
      append_number(text, mesh.vertices(v, k));
      text += k < 2 ? ' ' : '\n';
    }
  }
}

void append_triangles(std::string& text, const TriangleMesh& mesh, const char* prefix, int first_index) {
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    text += prefix;
    for (int k = 0; k < 3; ++k) {
      text += std::to_string(mesh.triangles(t, k) + first_index);
      text += k < 2 ? ' ' : '\n';
    }
  }
}

/// Little-endian bytes of a number.
template <typename T>
void append_binary(std::string& bytes, T value) {
  const char* const raw = reinterpret_cast<const char*>(&value);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes += raw[std::endian::native == std::endian::little ? i : sizeof(T) - 1 - i];
  }
}

std::string to_obj(const TriangleMesh& mesh) {
  std::string text;
  append_vertices(text, mesh, "v ");
  append_triangles(text, mesh, "f ", 1);
  return text;
}

std::string to_off(const TriangleMesh& mesh) {
  std::string text =
      "OFF\n" + std::to_string(mesh.vertices.rows()) + ' ' + std::to_string(mesh.triangles.rows()) + " 0\n";
  append_vertices(text, mesh, "");
  append_triangles(text, mesh, "3 ", 0);
  return text;
}

std::string to_ply(const TriangleMesh& mesh) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertices.rows()) +
                      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                      std::to_string(mesh.triangles.rows()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) append_binary(bytes, mesh.vertices(v, k));
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    bytes += '\3';
    for (int k = 0; k < 3; ++k) append_binary(bytes, mesh.triangles(t, k));
  }
  return bytes;
}

std::string to_stl(const std::filesystem::path& file, const TriangleMesh& mesh) {
  std::string bytes = "binary STL";
  bytes.resize(80, ' ');
  append_binary(bytes, static_cast<std::uint32_t>(mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0);
    Eigen::Vector3d normal = (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a);
    const double length = normal.norm();
    normal = length > 0 && std::isfinite(length) ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) append_binary(bytes, static_cast<float>(normal[k]));
    for (int corner = 0; corner < 3; ++corner) {
      for (int k = 0; k < 3; ++k) {
        const float x = static_cast<float>(mesh.corner(t, corner)[k]);
        if (!std::isfinite(x)) io::fail(file, "vertex", mesh.triangles(t, corner), "STL cannot hold this coordinate");
        append_binary(bytes, x);
      }
    }
    append_binary(bytes, std::uint16_t{0});
  }
  return bytes;
}

}  // namespace

void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh, const std::string& format) {
  std::string bytes;
  if (format == "obj") {
    bytes = to_obj(mesh);
  } else if (format == "off") {
    bytes = to_off(mesh);
  } else if (format == "ply") {
    bytes = to_ply(mesh);
  } else if (format == "stl") {
    bytes = to_stl(file, mesh);
  } else {
    io::fail(file, (format.empty() ? "no format to write a mesh in" : "meshes are not written as '" + format + "'") +
                       std::string(" (known: obj ply stl off)"));
  }
  write_atomically(file, bytes);
}

void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh) {
  write_mesh(file, mesh, io::format_of(file));
}

}  // namespace encage
