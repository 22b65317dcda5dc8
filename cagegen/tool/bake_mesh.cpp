// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/bake_mesh.h"

#include "cagegen/cli/cage_json.h"

#include <encage/error.h>

#include <array>
#include <cstddef>

namespace encage::tool {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const SanitizeReport& report) {
  return {{"welded_vertices", report.welded_vertices},         {"isolated_vertices", report.isolated_vertices},
          {"duplicate_triangles", report.duplicate_triangles}, {"degenerate_triangles", report.degenerate_triangles},
          {"flipped_components", report.flipped_components},   {"capped_loops", report.capped_loops}};
}

}  // namespace

BakedMesh bake_mesh(const std::filesystem::path& file, const TriangleMesh& mesh, const BakeOptions& options,
                    const BakeContext& context) {
  BakedMesh baked;
  baked.input_faces = mesh.triangles.rows();
  baked.input_vertices = mesh.vertices.rows();
  try {
    baked.source = sanitize(mesh);
    if (context.cancel != nullptr && *context.cancel) throw Cancelled();
    baked.hierarchy = bake(baked.source, options, context, &baked.report);
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    throw Error(file.string() + ": " + error.what());
  }
  return baked;
}

Json to_json(const BakedMesh& baked) {
  Json json = to_json(baked.hierarchy);
  Json& source = json["source"];
  source["faces"] = baked.input_faces;
  source["vertices"] = baked.input_vertices;
  source["sanitize"] = to_json(baked.source.report);
  for (std::size_t i = 0; i < baked.hierarchy.levels.size(); ++i) {
    const BakeReport::Level& times = baked.report.levels.at(i);
    json["levels"][i]["seconds"] = times.seconds;
    json["levels"][i]["flow_seconds"] = times.flow_seconds;
    json["levels"][i]["reinflate_seconds"] = times.reinflate_seconds;
    // bake() returns certified cages only; a clearance above 0 is part of each certificate.
    json["levels"][i]["certified"] = baked.hierarchy.levels[i].certificate.clearance > 0;
  }
  if (!baked.report.failure.empty()) json["failure"] = baked.report.failure;
  return json;
}

std::string describe(const SanitizeReport& report) {
  struct Item {
    std::int64_t count;
    const char* one;
    const char* many;
  };
  const std::array<Item, 6> items = {
      {{report.welded_vertices, "vertex welded", "vertices welded"},
       {report.isolated_vertices, "isolated vertex dropped", "isolated vertices dropped"},
       {report.duplicate_triangles, "duplicate face dropped", "duplicate faces dropped"},
       {report.degenerate_triangles, "degenerate face", "degenerate faces"},
       {report.flipped_components, "component turned", "components turned"},
       {report.capped_loops, "boundary loop capped", "boundary loops capped"}}};
  std::string text;
  for (const Item& item : items) {
    if (item.count == 0) continue;
    if (!text.empty()) text += ", ";
    text += std::to_string(item.count) + " " + (item.count == 1 ? item.one : item.many);
  }
  return text;
}

}  // namespace encage::tool
