// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/triplets.h"

#include "cagegen/render/levels.h"

#include <encage/error.h>

#include <algorithm>
#include <cassert>
#include <span>

namespace encage::zoo {

using render::Image;
using render::Item;

std::array<Image, 3> triplet(const CageHierarchy& hierarchy, render::Axis up, int size) {
  if (hierarchy.fine.triangles.rows() == 0 || hierarchy.levels.empty()) {
    throw Error("an asset with its source and a cage is needed");
  }
  const TriangleMesh& outermost = hierarchy.levels.back().mesh;
  render::Options options;
  options.width = options.height = size;
  options.up = up;
  const std::array input{render::level_item(hierarchy.fine, 0)};
  const std::array cage{render::level_item(outermost, static_cast<int>(hierarchy.levels.size()))};

  std::vector<Item> section = {render::level_item(hierarchy.fine, 0)};
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    section.push_back(render::level_item(hierarchy.levels[i].mesh, static_cast<int>(i) + 1));
  }
  for (Item& item : section) item.style = render::Style::section;
  render::Options across = options;
  const Eigen::AlignedBox3d box = bounds(outermost);
  Eigen::Index axis = 0;
  box.sizes().minCoeff(&axis);
  across.cut = render::Cut{static_cast<render::Axis>(axis), box.center()[axis]};
  return {render::render(input, options), render::render(section, across), render::render(cage, options)};
}

Image tiled(const std::vector<Image>& pictures, int columns) {
  assert(columns > 0);
  Image out;
  if (pictures.empty()) return out;
  const int width = pictures.front().width;
  const int height = pictures.front().height;
  const int count = static_cast<int>(pictures.size());
  out.width = columns * width;
  out.height = (count + columns - 1) / columns * height;
  out.rgb.assign(std::size_t{3} * static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height), 255);
  for (int i = 0; i < count; ++i) {
    const Image& picture = pictures[static_cast<std::size_t>(i)];
    assert(picture.width == width && picture.height == height);
    for (int y = 0; y < height; ++y) {
      const std::ptrdiff_t row = std::ptrdiff_t{i / columns} * height + y;
      const std::ptrdiff_t column = std::ptrdiff_t{i % columns} * width;
      std::copy_n(picture.pixel(0, y), 3 * width, out.rgb.begin() + 3 * (row * out.width + column));
    }
  }
  return out;
}

}  // namespace encage::zoo
