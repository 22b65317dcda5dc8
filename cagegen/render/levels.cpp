// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/levels.h"

#include <array>

namespace encage::render {

Color level_color(int level) {
  if (level == 0) return {0.97F, 0.75F, 0.30F};
  static const std::array<Color, 6> cages{Color(0.84F, 0.24F, 0.16F), Color(0.13F, 0.45F, 0.76F),
                                          Color(0.06F, 0.60F, 0.45F), Color(0.66F, 0.33F, 0.66F),
                                          Color(0.32F, 0.67F, 0.90F), Color(0.45F, 0.40F, 0.35F)};
  return cages[(level - 1) % cages.size()];
}

Item level_item(const TriangleMesh& mesh, int level) {
  Item item;
  item.mesh = &mesh;
  item.color = level_color(level);
  item.edges = level > 0;
  item.smooth = level == 0;
  return item;
}

std::vector<Item> nested_items(std::span<const TriangleMesh> levels) {
  std::vector<Item> items;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (levels[i].triangles.rows() == 0) continue;
    items.push_back(level_item(levels[i], static_cast<int>(i)));
    items.back().style = items.size() == 1 ? Style::solid : Style::section;
  }
  if (items.size() > 1) items.back().style = Style::translucent;
  return items;
}

}  // namespace encage::render
