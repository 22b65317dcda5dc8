// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/bake_mesh.h"

#include "cagegen/cli/cage_json.h"

#include <encage/error.h>

#include <cstddef>
#include <cstdint>
#include <string>

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
    if (options.keep_partial && !baked.report.failure.empty()) throw NoLevels(file.string() + ": " + error.what());
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
  json["missing_levels"] = baked.report.missing;
  if (!baked.report.failure.empty()) json["failure"] = baked.report.failure;
  return json;
}

std::string describe(const SourceMesh& source) {
  const SanitizeReport& report = source.report;
  const std::string loops = std::to_string(report.capped_loops);
  std::string text = source.solid == Solid::closed         ? "closed"
                     : source.solid == Solid::surface_only ? "encloses no volume: the cages enclose its surface"
                     : report.capped_loops == 1            ? "open in 1 place, which is capped"
                                                           : "open in " + loops + " places, which are capped";
  if (report.flipped_components > 0) text += "; parts that faced inward are turned";
  // Equal vertices that are welded, and vertices that nothing uses, change nothing.
  if (const std::int64_t idle = report.degenerate_triangles + report.duplicate_triangles; idle > 0) {
    text += "; " + std::to_string(idle) + (idle == 1 ? " face" : " faces") + " without area or twice there";
  }
  return text;
}

}  // namespace encage::tool
