// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/arguments.h"

#include <encage/error.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace encage::render {
namespace {

template <class Number>
std::optional<Number> parse(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Finite numbers between commas; empty if any is malformed.
std::vector<double> parse_list(std::string_view text) {
  std::vector<double> values;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto value = parse<double>(text.substr(begin, end - begin));
    if (!value || !std::isfinite(*value)) return {};
    values.push_back(*value);
    begin = end + 1;
  }
  return values;
}

[[noreturn]] void refuse(const char* what, std::string_view text, const char* expected) {
  throw Error(std::string(what) + " '" + std::string(text) + "': expected " + expected);
}

}  // namespace

Size parse_size(std::string_view text) {
  const std::size_t x = text.find('x');
  if (x != std::string_view::npos) {
    const auto width = parse<int>(text.substr(0, x)), height = parse<int>(text.substr(x + 1));
    if (width && height) return {*width, *height};
  }
  refuse("size", text, "WIDTHxHEIGHT in pixels, e.g. 1200x900");
}

Axis parse_axis(std::string_view text) {
  if (text == "x") return Axis::x;
  if (text == "y") return Axis::y;
  if (text == "z") return Axis::z;
  refuse("axis", text, "x, y or z");
}

Cut parse_cut(std::string_view text, const Eigen::AlignedBox3d& bounds) {
  const char* const expected = "x, y or z, or with an offset as in x=0.5";
  if (text.empty() || text[0] < 'x' || text[0] > 'z') refuse("cut", text, expected);
  Cut cut{parse_axis(text.substr(0, 1)), bounds.center()[text[0] - 'x']};
  if (text.size() == 1) return cut;
  const auto offset = parse<double>(text.substr(std::min<std::size_t>(2, text.size())));
  if (text[1] != '=' || !offset || !std::isfinite(*offset)) refuse("cut", text, expected);
  cut.offset = *offset;
  return cut;
}

Camera parse_camera(std::string_view text) {
  const std::vector<double> values = parse_list(text);
  if (values.size() != 2 && values.size() != 3) {
    refuse("camera", text, "azimuth,elevation[,zoom] with angles in degrees, e.g. 35,20,1.5");
  }
  Camera camera;
  camera.azimuth = values[0];
  camera.elevation = values[1];
  if (values.size() == 3) camera.zoom = values[2];
  return camera;
}

Eigen::Vector3d parse_point(std::string_view text) {
  const std::vector<double> values = parse_list(text);
  if (values.size() != 3) refuse("point", text, "x,y,z");
  return {values[0], values[1], values[2]};
}

}  // namespace encage::render
