// SPDX-License-Identifier: GPL-3.0-or-later

// Completes the seeds that the tests of the readers have left: compressed data out of the files of glTF, assets,
// descriptions of robots, poses.
#include "src/files/read_file.h"
#include "tests/fuzz/meshopt.h"
#include "tests/src/asset/sample.h"

#include <encage/asset.h>
#include <encage/poses.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace {

namespace fs = std::filesystem;
using namespace encage;
using Json = nlohmann::json;

void write(const fs::path& file, std::string_view bytes) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << bytes;
}

std::string decode_base64(std::string_view text) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < text.size() && text[i] != '='; ++i) {
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(text[i]) & 63);
    if (i % 4 != 0) bytes += static_cast<char>(bits >> (6 - 2 * (i % 4)));
  }
  return bytes;
}

/// The compressed data of a binary glTF file, with their parameters. Files that tests refuse may be anything.
void extract_meshopt(const std::string& glb, const fs::path& folder) {
  if (glb.size() < 20) return;
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  const Json json = Json::parse(glb.substr(20, length), nullptr, false);
  if (!json.is_object() || !json.contains("bufferViews")) return;
  for (const Json& view : json["bufferViews"]) {
    for (const char* const extension : {"KHR_meshopt_compression", "EXT_meshopt_compression"}) {
      try {
        const Json& how = view.at("extensions").at(extension);
        const Json& buffer = json.at("buffers").at(how.at("buffer").get<std::size_t>());
        const std::string uri = buffer.value("uri", "");
        const std::string bytes = uri.empty() ? glb.substr(28 + length) : decode_base64(uri.substr(uri.find(',') + 1));
        const std::string mode = how.at("mode"), filter = how.value("filter", "NONE");
        fuzz::MeshoptInput input{};
        input.mode = mode == "ATTRIBUTES" ? 0 : mode == "TRIANGLES" ? 1 : 2;
        const std::size_t stride = how.at("byteStride"), count = how.at("count");
        input.stride = static_cast<std::uint8_t>(input.mode == 0 ? stride / 4 - 1 : stride / 2 - 1);
        input.count = static_cast<std::uint16_t>((input.mode == 1 ? count / 3 : count) - 1);
        const auto* const known = std::find(std::begin(fuzz::meshopt_filters), std::end(fuzz::meshopt_filters), filter);
        input.filter = static_cast<std::uint8_t>(known - std::begin(fuzz::meshopt_filters));
        const std::string seed = std::string(reinterpret_cast<const char*>(&input), sizeof input) +
                                 bytes.substr(how.value("byteOffset", std::size_t{0}), how.at("byteLength"));
        write(folder / std::to_string(std::hash<std::string>()(seed)), seed);
      } catch (const std::exception&) {
        continue;
      }
    }
  }
}

std::string robot(const std::string& links) {
  return "<?xml version=\"1.0\"?><robot name=\"arm\">" + links + "</robot>";
}

std::string link(const std::string& shape) {
  return "<link name=\"a/b\"><collision><origin xyz=\"1 2 3\" rpy=\"0 0 1.5\"/><geometry>" + shape +
         "</geometry></collision></link><link name=\"tip\"/><joint name=\"j\" type=\"fixed\"/>";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s SEEDS TEST_DATA\n", argv[0]);
    return 2;
  }
  const fs::path seeds = argv[1];
  for (const auto& file : fs::directory_iterator(seeds / "glb")) {
    extract_meshopt(read_file(file.path()), seeds / "meshopt");
  }

  CageHierarchy sample = sample_hierarchy();
  fs::create_directories(seeds / "asset");
  write_asset(seeds / "asset" / "sample", sample);
  sample.fine = {};
  sample.cap_count = 0;
  write_asset(seeds / "asset" / "cages", sample);
  sample.levels.erase(sample.levels.begin());
  sample.options.clear();
  write_asset(seeds / "asset" / "cage", sample);
  for (const auto& file : fs::directory_iterator(argv[2])) {
    fs::copy_file(file.path(), seeds / "asset" / file.path().filename(), fs::copy_options::overwrite_existing);
  }

  int number = 0;
  for (const char* const shape :
       {"<mesh filename=\"fuzz_urdf\"/>", "<mesh filename=\"package://bin/fuzz_urdf\" scale=\"1 -2 3e-1\"/>",
        "<mesh filename=\"model://other/fuzz_urdf\"/><box size=\"1 1 1\"/><mesh filename='fuzz_urdf'/>",
        "<mesh filename=\"file:///nowhere/a.stl\"/>", "<sphere radius=\"1\"/><!-- none -->"}) {
    write(seeds / "urdf" / std::to_string(number++), robot(link(shape)));
  }
  write(seeds / "urdf" / "xacro", robot("<xacro:include filename=\"a\"/>"));

  fs::create_directories(seeds / "poses");
  const Eigen::Isometry3d turned(Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.6, 0, 0.8)));
  write_poses(seeds / "poses" / "two", {{0, {{0, turned}, {1, Eigen::Isometry3d::Identity()}}}, {3, {{1, turned}}}});
  return 0;
}
