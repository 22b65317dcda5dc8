// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/cage_json.h"

#include <optional>
#include <utility>

namespace encage::tool {

namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const CageLevel& level) {
  const Certificate& c = level.certificate;
  return {{"faces", level.mesh.triangles.rows()},
          {"vertices", level.mesh.vertices.rows()},
          {"volume", c.volume},
          {"volume_ratio", or_null(c.volume_ratio)},
          {"max_distance", or_null(c.max_distance)},
          {"mean_distance", or_null(c.mean_distance)},
          {"clearance", c.clearance},
          {"method", name(c.method)},
          {"start", c.start},
          {"genus", c.genus},
          {"components", c.components},
          {"cavities", c.cavities},
          {"no_new_handles", or_null(c.no_new_handles)}};
}

}  // namespace

Json to_json(const CageHierarchy& hierarchy) {
  Json levels = Json::array();
  for (const CageLevel& level : hierarchy.levels) levels.push_back(to_json(level));
  const Json options = Json::parse(hierarchy.options, nullptr, false);
  const Eigen::Vector3d& origin = hierarchy.origin;
  return {{"source",
           {{"solid", name(hierarchy.solid)},
            {"volume", hierarchy.source_volume},
            {"diagonal", hierarchy.diagonal},
            {"origin", {origin.x(), origin.y(), origin.z()}},
            {"hash", to_string(hierarchy.source_hash)},
            {"stored_faces", hierarchy.fine.triangles.rows()},
            {"caps", hierarchy.cap_count}}},
          {"options", options.is_discarded() ? Json(nullptr) : options},
          {"levels", std::move(levels)},
          {"truncated", hierarchy.truncated}};
}

std::string dump(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace encage::tool
