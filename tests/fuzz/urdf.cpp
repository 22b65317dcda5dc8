// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/urdf.h"

#include "tests/fuzz/fuzz.h"

#include <filesystem>
#include <set>
#include <string>

using namespace encage;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // A mesh that is there: this program. It is not opened.
  static const std::filesystem::path name =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "robot.urdf";
  tool::Urdf urdf;
  const bool is_read = fuzz::reads(fuzz::memory_for(size), [&] {
    urdf = tool::read_urdf(name, {reinterpret_cast<const char*>(data), size});
  });
  if (!is_read) return 0;
  fuzz::require(!urdf.meshes.empty(), "no meshes");
  std::set<std::string> bodies;
  for (const tool::UrdfMesh& mesh : urdf.meshes) {
    fuzz::require(mesh.scale.allFinite() && (mesh.scale.array() != 0).all(), "a scale is 0 or not finite");
    fuzz::require(mesh.origin_xyz.allFinite() && mesh.origin_rpy.allFinite(), "an origin is not finite");
    fuzz::require(bodies.insert(mesh.body).second, "two bodies of one name");
    // They become names of files.
    const bool is_name = mesh.body.find('/') == mesh.body.npos && !mesh.body.starts_with('.') && mesh.body.size() < 250;
    fuzz::require(is_name, "a body is no name of a file");
  }
  return 0;
}
