// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/gallery.h"

#include "cagegen/render/render.h"

#include <array>
#include <span>
#include <vector>

namespace encage::zoo {

namespace {

using render::Item;

constexpr int width = 640;
constexpr int height = 480;

const render::Color source_color(0.85F, 0.45F, 0.35F);

/// Fine to coarse, again from the first if there are more levels.
render::Color cage_color(std::size_t level) {
  static const std::array<render::Color, 4> colors = {
      render::Color(0.20F, 0.45F, 0.80F), render::Color(0.20F, 0.65F, 0.35F), render::Color(0.80F, 0.60F, 0.15F),
      render::Color(0.55F, 0.35F, 0.75F)};
  return colors[level % colors.size()];
}

void write(const std::filesystem::path& prefix, const char* what, std::span<const Item> items,
           const std::optional<render::Cut>& cut = std::nullopt) {
  render::Options options;
  options.width = width;
  options.height = height;
  options.cut = cut;
  render::write_png(prefix.string() + "-" + what + ".png", render::render(items, options));
}

render::Cut middle_cut(const TriangleMesh& outermost) {
  const Eigen::AlignedBox3d box = bounds(outermost);
  Eigen::Index axis = 0;
  box.sizes().minCoeff(&axis);
  return {static_cast<render::Axis>(axis), box.center()[axis]};
}

}  // namespace

void write_pictures(const std::filesystem::path& prefix, const SourceMesh& source, const CageHierarchy& hierarchy) {
  const Item solid{.mesh = &source.obstacle, .color = source_color};
  write(prefix, "input", std::array{solid});
  if (hierarchy.levels.empty()) return;

  const TriangleMesh& outermost = hierarchy.levels.back().mesh;
  const Item cage{.mesh = &outermost,
                  .color = cage_color(hierarchy.levels.size() - 1),
                  .style = render::Style::translucent,
                  .edges = true,
                  .smooth = false};
  write(prefix, "cage", std::array{solid, cage});

  std::vector<Item> section = {{.mesh = &source.obstacle, .color = source_color, .style = render::Style::section}};
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    section.push_back({.mesh = &hierarchy.levels[i].mesh, .color = cage_color(i), .style = render::Style::section});
  }
  write(prefix, "section", section, middle_cut(outermost));
}

}  // namespace encage::zoo
