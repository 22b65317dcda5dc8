// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/output_file.h"
#include "cagegen/tool/bake_mesh.h"
#include "cagegen/tool/command.h"
#include "cagegen/tool/input.h"
#include "src/asset/view.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace encage::tool {

namespace {

constexpr const char* check_examples = R"(Examples:
  encage check model.glb
      every byte against its hash; every cage proven again around the next finer level
  encage check model.glb --source model.obj
      the same, the first cage around the source itself, in double

Each line says holds, refuted or unproven. Without --source the first cage is proven
around the float32 mesh stored in the asset, if there is one.
Exit status: 0 if everything holds; 1 if something is refuted or cannot be proven, or
the asset is damaged; 2 if a file cannot be read or FILE.glb is no binary glTF file.)";

struct CheckArguments {
  std::filesystem::path asset;
  std::optional<std::filesystem::path> source;
  std::filesystem::path json;
  std::string format;
};

SourceMesh read_source(const std::filesystem::path& file, const std::string& format) {
  const TriangleMesh mesh = Input(file, format).mesh(print_note);
  try {
    return sanitize(mesh);
  } catch (const Error& error) {
    throw Error(file.string() + ": " + error.what());
  }
}

bool same_bytes(std::span<const std::byte> x, std::span<const std::byte> y) {
  return std::equal(x.begin(), x.end(), y.begin(), y.end());
}

/// What the asset stores for queries must be safe to traverse, and what the mesh implies.
CheckReport::Check check_query_arrays(const AssetView& view, const CageHierarchy& hierarchy) {
  const std::string subject = "query arrays";
  std::size_t meshes = 0;
  const auto require = [&](const std::optional<MeshArraysView>& stored, const TriangleMesh& mesh,
                           const std::string& place) {
    if (!stored) return;
    check_bounds(stored->tree, stored->mesh, place);
    const MeshArrays expected = make_mesh_arrays(mesh, place);
    if (!same_bytes(std::as_bytes(stored->owned), std::as_bytes(std::span(expected.owned))) ||
        !same_bytes(std::as_bytes(stored->parts), std::as_bytes(std::span(expected.parts)))) {
      throw Error(place + ": owners or parts are not those of the mesh");
    }
    ++meshes;
  };
  try {
    if (view.fine()) require(view.fine_arrays(), hierarchy.fine, fine_name);
    for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
      require(view.cage_arrays(i), hierarchy.levels[i].mesh, cage_name(i));
    }
  } catch (const Error& error) {
    return {subject, CheckVerdict::refuted, error.what()};
  }
  return {subject, CheckVerdict::holds,
          meshes == 0 ? "none are stored" : "of " + std::to_string(meshes) + " meshes: trees, owners, parts"};
}

CheckReport check(const CheckArguments& a, Input& asset) {
  std::optional<SourceMesh> source;
  if (a.source) source = read_source(*a.source, a.format);
  std::optional<AssetView> view;
  CageHierarchy hierarchy;
  try {
    view.emplace(asset.view(Verify::all));
    hierarchy = copy_hierarchy(*view);
  } catch (const Error& error) {
    return {{{"file", CheckVerdict::refuted, error.what()}}};
  }
  CheckReport report = check_asset(hierarchy, source ? &*source : nullptr);
  report.checks.insert(report.checks.begin(), check_query_arrays(*view, hierarchy));
  report.checks.insert(report.checks.begin(), {"file", CheckVerdict::holds, "every byte as written"});
  return report;
}

void print(const CheckReport& report) {
  for (const CheckReport::Check& c : report.checks) {
    std::cout << std::left << std::setw(10) << name(c.verdict) << std::setw(20) << c.subject << c.detail << '\n';
  }
}

nlohmann::ordered_json to_json(const CheckArguments& a, const CheckReport& report) {
  nlohmann::ordered_json json = {{"asset", a.asset.string()}};
  if (a.source) json["source"] = a.source->string();
  json["holds"] = report.holds();
  json["checks"] = nlohmann::ordered_json::array();
  for (const CheckReport::Check& c : report.checks) {
    json["checks"].push_back({{"subject", c.subject}, {"verdict", name(c.verdict)}, {"detail", c.detail}});
  }
  return json;
}

}  // namespace

void add_check(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("check", "Prove the cages of an asset again");
  command->footer(check_examples);
  const auto a = std::make_shared<CheckArguments>();
  command->add_option("asset", a->asset, "Asset written by encage bake; - for standard input")
      ->required()
      ->type_name("FILE.glb");
  command->add_option("--source", a->source, "The mesh that it was baked from; - for standard input")
      ->type_name("FILE");
  command->add_option("--format", a->format, "Format of the source, instead of its extension")->type_name("FORMAT");
  add_json(*command, a->json, "Write the verdicts as JSON; without FILE instead of the text");
  command->callback([a, &status] {
    if (a->asset == "-" && a->source && *a->source == "-") throw Error("-: asset and source cannot be the same file");
    Input asset(a->asset);
    asset.require_glb();
    if (!a->json.empty()) check_output(a->json, a->asset);
    if (!a->json.empty() && a->source) check_output(a->json, *a->source);
    const CheckReport report = check(*a, asset);
    print(report);
    if (!a->json.empty()) write_json(a->json, to_json(*a, report));
    status = report.holds() ? success : answer_is_no;
  });
}

}  // namespace encage::tool
