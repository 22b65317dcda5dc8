// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/input.h"

#include "cagegen/cli/is_asset.h"
#include "src/files/read_file.h"

#include <encage/asset.h>
#include <encage/error.h>

#include <fstream>
#include <iostream>
#include <system_error>
#include <utility>

namespace encage::tool {

namespace fs = std::filesystem;

namespace {

/// A pipe, a device, standard input. What is missing counts as a file, whose readers have the message.
bool is_no_file(const fs::path& file) {
  std::error_code none;
  const fs::file_type type = fs::status(file, none).type();
  return file == "-" || (type != fs::file_type::regular && type != fs::file_type::directory &&
                         type != fs::file_type::not_found && type != fs::file_type::none);
}

}  // namespace

Input::Input(fs::path file, std::string format)
    : file_(std::move(file)),
      format_(std::move(format)),
      name_(file_ == "-" ? "standard input" : file_.string()),
      is_stream_(is_no_file(file_)) {}

std::string_view Input::bytes() {
  if (!bytes_) bytes_ = file_ == "-" ? read_standard_input(name_) : read_file(file_);
  return *bytes_;
}

std::string Input::format() const {
  std::string format = format_;
  if (format.empty() && file_.has_extension()) format = file_.extension().string().substr(1);
  for (char& c : format) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return format;
}

bool Input::is_asset() { return is_stream_ ? begins_like_asset(bytes()) : tool::is_asset(file_); }

void Input::require_glb() {
  std::string magic(4, '\0');
  if (is_stream_) {
    magic = bytes().substr(0, magic.size());
  } else {
    std::ifstream file(file_, std::ios::binary);
    if (!file || fs::is_directory(file_)) throw Error(name_ + ": cannot be opened");
    file.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  }
  if (magic != "glTF") throw Error(name_ + ": not a binary glTF file");
}

AssetView Input::view(Verify verify) {
  if (!is_stream_) return AssetView(file_, verify);
  aligned_ = AlignedBytes(bytes());
  return AssetView(aligned_.span(), name_, verify);
}

CageHierarchy Input::asset(Verify verify) {
  return is_stream_ ? decode_asset(bytes(), name_, verify) : read_asset(file_, verify);
}

TriangleMesh Input::mesh(const NoteSink& note) {
  ReadNotes notes;
  PolygonMesh polygons;
  if (is_stream_ || !format_.empty()) {
    if (format().empty()) throw Error(name_ + ": has no extension that tells the format; name it with --format");
    polygons = decode_polygon_mesh(bytes(), format(), name_, &notes);
  } else {
    polygons = read_polygon_mesh(file_, &notes);
  }
  for (const std::string& text : notes) note(name_ + ": " + text);
  return triangulate(polygons);
}

void print_note(const std::string& note) { std::cerr << "note: " << note << std::endl; }

}  // namespace encage::tool
