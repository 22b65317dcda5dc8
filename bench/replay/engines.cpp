// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/engines.h"

#include "bench/replay/bullet_engine.h"
#include "bench/replay/embree_engine.h"
#include "bench/replay/encage_engine.h"
#include "bench/replay/fcl_engine.h"
#include "bench/replay/ode_engine.h"

#include <encage/error.h>

#include <functional>
#include <initializer_list>

namespace encage::replay {
namespace {

using Engines = std::vector<std::unique_ptr<Engine>>;

Engines one(std::unique_ptr<Engine> engine) {
  Engines engines;
  engines.push_back(std::move(engine));
  return engines;
}

Engines embree(const ReplayBody& body, std::initializer_list<EmbreeUpdate> updates) {
  Engines engines;
  for (const EmbreeUpdate update : updates) engines.push_back(make_embree_engine(body.mesh, body.shape, update));
  return engines;
}

struct Entry {
  std::string name;
  std::function<Engines(const ReplayBody&)> make;
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = {
      {"encage", [](const ReplayBody& body) { return one(make_encage_engine(body.shape)); }},
      {"fcl", [](const ReplayBody& body) { return one(make_fcl_engine(body.mesh, FclVolume::obbrss)); }},
      {"fcl_obb", [](const ReplayBody& body) { return one(make_fcl_engine(body.mesh, FclVolume::obb)); }},
      {"fcl_float", [](const ReplayBody& body) { return one(make_fcl_engine(body.mesh, FclVolume::obbrss_float)); }},
      {"bullet", [](const ReplayBody& body) { return one(make_bullet_engine(body.mesh)); }},
      {"ode", [](const ReplayBody& body) { return one(make_ode_engine(body.mesh)); }},
      {"embree",
       [](const ReplayBody& body) {
         return embree(body, {EmbreeUpdate::refit, EmbreeUpdate::rebuild});
       }},
      {"embree_refit", [](const ReplayBody& body) { return embree(body, {EmbreeUpdate::refit}); }},
      {"embree_rebuild", [](const ReplayBody& body) { return embree(body, {EmbreeUpdate::rebuild}); }},
  };
  return all;
}

}  // namespace

const std::vector<std::string>& engine_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Entry& entry : entries()) list.push_back(entry.name);
    return list;
  }();
  return names;
}

Engines make_engines(const std::string& name, const ReplayBody& body) {
  for (const Entry& entry : entries()) {
    if (entry.name == name) return entry.make(body);
  }
  throw Error("no engine '" + name + "'");
}

}  // namespace encage::replay
