// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/progress.h"
#include "cagegen/cli/usage.h"
#include "cagegen/tool/bake_mesh.h"
#include "cagegen/tool/bake_options.h"
#include "cagegen/tool/bake_robot.h"
#include "cagegen/tool/command.h"
#include "cagegen/tool/flow_options.h"
#include "cagegen/tool/input.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace encage::tool {

namespace {

constexpr const char* bake_examples = R"(Examples:
  encage bake model.obj
      cages that suit the model's size, into model.glb in the current folder
  encage bake model.obj -o cages.glb --faces 8000,2000,500
      three nested cages of at most that many triangles
  encage bake model.obj --ratio 0.25 --levels 4 --json bake.json
      four cages, each with a quarter of the faces of the one before; figures as JSON
  encage bake model.obj --method flow --decimator adaptive --faces 2000,500 --keep-partial
      cages by flow and re-inflation; if the second fails, the first is written, with exit status 1
  encage bake model.obj --coarse fine.obj,coarse.obj
      turns two meshes of your own into cages, the second around the first
  encage bake robot.urdf -o robot --ratio 0.1 --levels 2
      every collision mesh of a robot, an asset each, into the folder robot
  convert model.step - | encage bake - --format stl -o - | encage info - --json
      meshes and assets through pipes)";

struct BakeArguments {
  std::filesystem::path input;
  std::filesystem::path output;
  std::filesystem::path json;
  std::string format;
  double ratio = 0;
  int levels = 0;
  double time_limit = 0;
  bool no_source = false;
  bool verbose = false;
  BakeOptions options;
  FlowOptions flow;
};

/// Both ends excluded. (CLI::Range includes them, and accepts NaN.)
CLI::Validator between(double low, double high, const std::string& wanted) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value > low && value < high) return {};
        return text + " is not " + wanted;
      },
      "");
}

void print_level(std::size_t number, const CageLevel& level, double seconds) {
  const Certificate& c = level.certificate;
  char volume[64];
  if (c.volume_ratio) {
    std::snprintf(volume, sizeof volume, "volume ratio %.4f", *c.volume_ratio);
  } else {
    std::snprintf(volume, sizeof volume, "volume %.6g", c.volume);
  }
  char line[256];
  std::snprintf(line, sizeof line, "level %zu: %7lld faces  %s  distance at most %.3g, mean %.3g  clearance %.3g  %s",
                number, static_cast<long long>(level.mesh.triangles.rows()), volume, c.max_distance.value(),
                c.mean_distance.value(), c.clearance, name(c.method));
  std::cout << line;
  if (!c.start.empty()) std::cout << " from " << c.start;
  std::snprintf(line, sizeof line, "  %.2f s", seconds);
  std::cout << line << '\n';
}

/// Where the asset goes. Throws Error if a result could not be written, before any long work.
std::filesystem::path checked_output(const BakeArguments& arguments) {
  const std::filesystem::path output = arguments.output.empty() ? default_asset(arguments.input) : arguments.output;
  if (output.extension() != ".glb" && !has_no_format(output)) {
    throw Error(output.string() + ": cages are written as .glb only");
  }
  std::vector<std::filesystem::path> inputs = arguments.flow.coarse_files();
  inputs.push_back(arguments.input);
  for (const std::filesystem::path& input : inputs) {
    check_output(output, input);
    if (!arguments.json.empty()) check_output(arguments.json, input);
  }
  check_different(output, arguments.json);
  return output;
}

BakedMesh read_and_bake(BakeArguments& arguments) {
  Progress progress = Progress::on_stderr();
  progress.update(0, "reading");
  const NoteSink note = [&](const std::string& text) { progress.note(text); };
  Input input(arguments.input, arguments.format);
  const TriangleMesh mesh = input.mesh(note);
  arguments.flow.read_coarse(arguments.options, note);
  throw_if_interrupted();
  progress.update(0, "sanitizing");
  BakeContext context = progress.context(&interrupted);
  if (arguments.verbose) context.trace = context.log;
  BakedMesh baked = bake_mesh(input.name(), mesh, arguments.options, context);
  throw_if_interrupted();
  return baked;
}

void print_bake(const std::string& input, const std::filesystem::path& output, const BakedMesh& baked) {
  std::cout << input << ": " << baked.input_faces << " triangles, " << describe(baked.source) << '\n';
  for (std::size_t i = 0; i < baked.hierarchy.levels.size(); ++i) {
    print_level(i + 1, baked.hierarchy.levels[i], baked.report.levels.at(i).seconds);
  }
  if (baked.hierarchy.truncated) std::cout << "the time limit cut the work short\n";
  std::cout << "wrote " << output_name(output) << '\n';
}

void write_figures(const BakeArguments& arguments, const std::filesystem::path& output, const BakedMesh& baked,
                   double seconds) {
  const Usage usage = process_usage();
  nlohmann::ordered_json json = {{"input", arguments.input.string()}, {"output", output.string()}};
  json.update(to_json(baked));
  json["seconds"] = seconds;
  json["bake_seconds"] = baked.report.seconds;
  json["cpu_seconds"] = usage.cpu_seconds;
  json["peak_rss_bytes"] = usage.peak_rss_bytes;
  write_json(arguments.json, json);
}

int run_robot(const BakeArguments& arguments) {
  if (!arguments.flow.coarse_files().empty()) throw Error("--coarse: is for a single mesh, not for a robot");
  return bake_robot({arguments.input, arguments.output, arguments.json, arguments.options, arguments.verbose},
                    print_bake);
}

/// The exit status.
int run_bake(BakeArguments& arguments) {
  if (is_robot(Input(arguments.input, arguments.format).format())) return run_robot(arguments);
  const auto began = std::chrono::steady_clock::now();
  const InterruptScope scope;
  const std::filesystem::path output = checked_output(arguments);
  print_beside(output);
  const BakedMesh baked = read_and_bake(arguments);
  write_certified_asset(output_path(output), baked.hierarchy);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  print_bake(Input(arguments.input).name(), output, baked);
  if (!arguments.json.empty()) write_figures(arguments, output, baked, seconds);
  if (baked.report.failure.empty()) return success;
  std::cerr << "encage: " << Input(arguments.input).name() << ": " << baked.report.failure << "; "
            << output_name(output) << " holds the others\n";
  return answer_is_no;
}

}  // namespace

void add_bake(CLI::App& app, int& status) {
  CLI::App* bake = app.add_subcommand("bake", "Bake certified nested cages around a mesh");
  bake->footer(bake_examples);
  const auto a = std::make_shared<BakeArguments>();
  bake->add_option(
          "input", a->input,
          "Mesh: .obj, .ply, .stl, .off, .gltf, .glb or what Assimp reads; or a robot, .urdf; - for standard input")
      ->required()
      ->type_name("IN");
  bake->add_option(
          "-o,--output", a->output,
          "Asset to write, of a robot the folder for its assets; by default IN's name in the current folder; - for "
          "standard output")
      ->type_name("OUT.glb");
  bake->add_option("--format", a->format, "Format of IN, instead of its extension")->type_name("FORMAT");
  CLI::Option* faces = add_faces(*bake, a->options);
  CLI::Option* ratio = bake->add_option("--ratio", a->ratio, "Faces of a level over faces of the one before")
                           ->check(between(0, 1, "a number between 0 and 1"))
                           ->excludes(faces)
                           ->type_name("R");
  CLI::Option* levels = bake->add_option("--levels", a->levels, "Number of cages")
                            ->check(CLI::Range(1, 64).description(""))
                            ->excludes(faces)
                            ->type_name("N");
  add_method(*bake, a->options);
  a->flow.add(*bake, a->options, {faces, ratio, levels});
  add_topology(*bake, a->options);
  bake->add_option("--min-clearance", a->options.min_clearance,
                   "Least distance between consecutive surfaces, in diagonals of the source (default 1e-5)")
      ->check(between(0, 0.1, "a number between 0 and 0.1"))
      ->type_name("D");
  add_threads(*bake, a->options);
  CLI::Option* time_limit =
      bake->add_option(
              "--time-limit", a->time_limit,
              "Stop improving after so many seconds; the result may then vary, and if levels are left out, the exit "
              "status is 1")
          ->check(between(0, std::numeric_limits<double>::infinity(), "a number of seconds above 0"))
          ->type_name("S");
  bake->add_flag(
      "--keep-partial", a->options.keep_partial,
      "If a level cannot be made, write those before it; the exit status is 1, also if there are none, or fewer than "
      "--levels");
  bake->add_flag("--no-source", a->no_source, "Leave the source mesh (level 0) out of the asset");
  bake->add_flag("--verbose", a->verbose, "Note what the makers of the cages try, and what fails");
  add_json(*bake, a->json);
  bake->callback([=, &status] {
    a->flow.check(a->options);
    if (*ratio) a->options.ratio = a->ratio;
    if (*levels) a->options.level_count = a->levels;
    if (*time_limit) a->options.time_limit = a->time_limit;
    a->options.keep_fine = !a->no_source;
    try {
      status = run_bake(*a);
    } catch (const NoLevels& error) {
      std::cerr << "encage: " << error.what() << "; nothing was written\n";
      status = answer_is_no;
    }
  });
}

}  // namespace encage::tool
