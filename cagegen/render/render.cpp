// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/render.h"

#include "cagegen/render/camera.h"
#include "cagegen/render/section.h"
#include "cagegen/render/surface.h"
#include "src/mesh/portable_trig.h"

#include <encage/error.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

namespace encage::render {
namespace {

constexpr int samples = 2;         // a pixel, in x and in y
constexpr int occlusion_rays = 6;  // a sample
constexpr double golden_turn = 0.3819660112501051;
constexpr double infinite = std::numeric_limits<double>::infinity();

// Light is added linearly; a square root is close enough to the display's curve, and the same on every machine.
Color to_linear(const Color& displayed) { return displayed.cwiseProduct(displayed); }
Color to_displayed(const Color& linear) { return linear.cwiseMax(0.F).cwiseMin(1.F).cwiseSqrt(); }
Color mix(const Color& under, const Color& over, float alpha) { return under + alpha * (over - under); }

// Small integer hash (Wang) for the rotation of sample patterns.
std::uint32_t scramble(std::uint32_t x) {
  x = (x ^ 61U) ^ (x >> 16);
  x *= 9U;
  x ^= x >> 4;
  x *= 0x27d4eb2dU;
  return x ^ (x >> 15);
}

// How a sample turns and stretches the spirals that rays are spread on.
struct Shift {
  double radius;  // in [0,1)
  double turn;
};

// Differs from pixel to pixel; the samples of one pixel share out what lies between.
Shift shift_of(int sx, int sy) {
  const auto px = static_cast<std::uint32_t>(sx / samples), py = static_cast<std::uint32_t>(sy / samples);
  const std::uint32_t seed = scramble(py * 65536U + px);
  const int index = sy % samples * samples + sx % samples;
  const double radius = (seed & 0xffffU) / 65536.0 + index / static_cast<double>(samples * samples);
  return {radius - std::floor(radius), (seed >> 16) / 65536.0 + index * golden_turn / occlusion_rays};
}

struct Prepared {
  Color linear;
  std::vector<Eigen::Vector3f> normals;
  std::unique_ptr<Section> section;
};

class Renderer {
 public:
  Renderer(std::span<const Item> items, const Options& options, const View& view, const Eigen::AlignedBox3d& box);
  Image draw() const;

 private:
  Color pixel(int x, int y) const;
  Color sample(int sx, int sy) const;
  Color solid(const Ray& ray, const Hit& hit, const Shift& shift) const;
  float visible_sky(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, const Shift& shift) const;
  Color translucent(const Color& under, const Ray& ray, const Hit& hit) const;
  void shade_section(Color& color, int sx, int sy) const;
  Eigen::Vector3d normal_at(const Ray& ray, const Hit& hit) const;
  float edge_coverage(const Hit& hit, const Eigen::Vector2d& pixel_position) const;
  /// Restricts a ray to what the cut leaves; false if nothing is left.
  bool clip(Ray& ray) const;

  std::span<const Item> items_;
  const Options& options_;
  const View& view_;
  double diagonal_;
  Eigen::Vector3d key_light_;
  std::vector<Prepared> prepared_;
  std::unique_ptr<Scene> solids_;
  std::vector<std::unique_ptr<Scene>> veils_;  // one per translucent item
};

Renderer::Renderer(std::span<const Item> items, const Options& options, const View& view,
                   const Eigen::AlignedBox3d& box)
    : items_(items),
      options_(options),
      view_(view),
      diagonal_(box.diagonal().norm()),
      key_light_((-0.45 * view.right() + 0.7 * view.up() - 0.6 * view.forward()).normalized()),
      prepared_(items.size()) {
  std::vector<std::uint32_t> opaque;
  for (std::uint32_t i = 0; i < items.size(); ++i) {
    const Item& item = items[i];
    prepared_[i].linear = to_linear(item.color);
    if (item.style != Style::section) prepared_[i].normals = corner_normals(*item.mesh, item.smooth);
    if (item.style == Style::solid) opaque.push_back(i);
    if (item.style == Style::translucent) {
      veils_.push_back(std::make_unique<Scene>(items, std::vector{i}, box.center()));
    }
    if (options.cut) {
      prepared_[i].section = std::make_unique<Section>(slice(*item.mesh, *options.cut), is_closed(*item.mesh), view,
                                                       options.width, options.height, samples);
    }
  }
  solids_ = std::make_unique<Scene>(items, opaque, box.center());
}

Image Renderer::draw() const {
  Image image{options_.width, options_.height, {}};
  image.rgb.resize(static_cast<std::size_t>(image.width) * image.height * 3);
  tbb::parallel_for(tbb::blocked_range<int>(0, image.height, 4), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < image.width; ++x) {
        const Color color = to_displayed(pixel(x, y));
        for (int k = 0; k < 3; ++k) {
          image.rgb[(static_cast<std::size_t>(y) * image.width + x) * 3 + k] =
              static_cast<std::uint8_t>(color[k] * 255 + 0.5F);
        }
      }
    }
  });
  return image;
}

Color Renderer::pixel(int x, int y) const {
  Color sum = Color::Zero();
  for (int j = 0; j < samples; ++j) {
    for (int i = 0; i < samples; ++i) sum += sample(x * samples + i, y * samples + j);
  }
  Color color = sum / static_cast<float>(samples * samples);
  for (std::size_t i = items_.size(); i-- > 0;) {
    if (!prepared_[i].section) continue;
    // Darker than the tint, so that the outline of the innermost solid reads as well.
    const Color line = to_linear(0.8F * items_[i].color);
    color = mix(color, line, prepared_[i].section->contour(x, y));
  }
  return color;
}

Color Renderer::sample(int sx, int sy) const {
  const Eigen::Vector2d position((sx + 0.5) / samples, (sy + 0.5) / samples);
  Ray ray{view_.eye(), view_.ray_direction(position), 0, infinite};
  Color color = Color::Ones();
  if (clip(ray)) {
    double depth = infinite;
    if (const auto hit = solids_->nearest(ray)) {
      depth = hit->distance;
      color = solid(ray, *hit, shift_of(sx, sy));
      if (items_[hit->item].edges) color *= 1 - 0.75F * edge_coverage(*hit, position);
    }
    std::vector<Hit> veils;
    for (const auto& veil : veils_) {
      if (const auto hit = veil->nearest(ray); hit && hit->distance < depth) veils.push_back(*hit);
    }
    std::sort(veils.begin(), veils.end(), [](const Hit& a, const Hit& b) { return a.distance > b.distance; });
    for (const Hit& hit : veils) {
      color = translucent(color, ray, hit);
      if (!items_[hit.item].edges) continue;
      color = mix(color, 0.25F * prepared_[hit.item].linear, 0.85F * edge_coverage(hit, position));
    }
  }
  shade_section(color, sx, sy);
  return color;
}

Color Renderer::solid(const Ray& ray, const Hit& hit, const Shift& shift) const {
  const Eigen::Vector3d normal = normal_at(ray, hit);
  const Eigen::Vector3d point = ray.origin + hit.distance * ray.direction + 1e-4 * diagonal_ * normal;
  // A lamp of some size: soft edges of shadows.
  const SinCos place = sincos_turns(shift.turn);
  const double off = 0.1 * std::sqrt(shift.radius);
  const Eigen::Vector3d lamp = (key_light_ + off * (place.cos * view_.right() + place.sin * view_.up())).normalized();
  Ray shadow{point, lamp, 0, infinite};
  const double facing = normal.dot(key_light_);
  const bool lit = facing > 0 && !(clip(shadow) && solids_->blocked(shadow));
  const float key = lit ? static_cast<float>(facing) : 0.F;
  // Light from above and, weaker, from below, as in a bright room.
  const float hemisphere = static_cast<float>(0.75 + 0.25 * normal.dot(view_.up()));
  const float sky = hemisphere * visible_sky(point, normal, shift);
  const Color base = prepared_[hit.item].linear;
  const Eigen::Vector3d half = (key_light_ - ray.direction).normalized();
  double gloss = std::max(0.0, normal.dot(half));
  for (int i = 0; i < 5; ++i) gloss *= gloss;  // 32nd power
  const float highlight = lit ? static_cast<float>(0.10 * gloss) : 0.F;
  return (0.72F * sky + 0.50F * key) * base + highlight * Color::Ones();
}

float Renderer::visible_sky(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, const Shift& shift) const {
  const Eigen::Vector3d helper = std::abs(normal.x()) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d tangent = normal.cross(helper).normalized(), bitangent = normal.cross(tangent);
  int free = 0;
  for (int i = 0; i < occlusion_rays; ++i) {
    // Cosine-weighted: uniform on the disc below the hemisphere, a spiral of golden angles.
    const double r2 = (i + shift.radius) / occlusion_rays;
    const SinCos angle = sincos_turns(shift.turn + i * golden_turn);
    const double r = std::sqrt(r2);
    const Eigen::Vector3d direction = r * angle.cos * tangent + r * angle.sin * bitangent + std::sqrt(1 - r2) * normal;
    Ray ray{point, direction, 0, 0.5 * diagonal_};
    free += !(clip(ray) && solids_->blocked(ray));
  }
  return static_cast<float>(free) / occlusion_rays;
}

Color Renderer::translucent(const Color& under, const Ray& ray, const Hit& hit) const {
  const Eigen::Vector3d normal = normal_at(ray, hit);
  const double grazing = 1 - std::abs(normal.dot(ray.direction));
  const float alpha = static_cast<float>(0.22 + 0.45 * grazing * grazing);
  const float light = static_cast<float>(0.75 + 0.35 * std::max(0.0, normal.dot(key_light_)));
  return mix(under, light * prepared_[hit.item].linear, alpha);
}

void Renderer::shade_section(Color& color, int sx, int sy) const {
  for (std::size_t i = items_.size(); i-- > 0;) {
    if (!prepared_[i].section || !prepared_[i].section->inside(sx, sy)) continue;
    const Color tint = to_linear(mix(items_[i].color, Color::Ones(), 0.55F));
    color = i == 0 ? tint : mix(color, tint, 0.8F);
  }
}

Eigen::Vector3d Renderer::normal_at(const Ray& ray, const Hit& hit) const {
  const Eigen::Vector3f* n = &prepared_[hit.item].normals[std::size_t{3} * hit.triangle];
  const Eigen::Vector3f sum = (1 - hit.u - hit.v) * n[0] + hit.u * n[1] + hit.v * n[2];
  const Eigen::Vector3d normal = sum.cast<double>().normalized();
  return normal.dot(ray.direction) > 0 ? Eigen::Vector3d(-normal) : normal;
}

float Renderer::edge_coverage(const Hit& hit, const Eigen::Vector2d& pixel_position) const {
  const TriangleMesh& mesh = *items_[hit.item].mesh;
  std::array<Eigen::Vector2d, 3> p;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d corner = mesh.corner(hit.triangle, k);
    if ((corner - view_.eye()).dot(view_.forward()) <= 0) return 0;
    p[k] = view_.project(corner);
  }
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  const double area = std::abs(cross(p[1] - p[0], p[2] - p[0]));
  double nearest = infinite, longest = 0;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2d edge = p[(k + 1) % 3] - p[k];
    const double length = edge.norm();
    longest = std::max(longest, length);
    if (length > 0) nearest = std::min(nearest, std::abs(cross(edge, pixel_position - p[k])) / length);
  }
  // Fade where lines would cover the surface: triangles under a few pixels.
  const double fade = std::clamp((std::sqrt(area) - 4) / 8, 0.0, 1.0);
  return static_cast<float>(fade * std::clamp(1.15 - nearest, 0.0, 1.0));
}

bool Renderer::clip(Ray& ray) const {
  if (!options_.cut) return true;
  const int axis = static_cast<int>(options_.cut->axis);
  const double side = view_.eye()[axis] > options_.cut->offset ? -1 : 1;  // what is kept
  const double height = side * (ray.origin[axis] - options_.cut->offset);
  const double slope = side * ray.direction[axis];
  if (slope > 0) {
    ray.near = std::max(ray.near, -height / slope);
  } else if (slope < 0) {
    ray.far = std::min(ray.far, -height / slope);
  } else if (height < 0) {
    return false;
  }
  return ray.near < ray.far;
}

Eigen::AlignedBox3d bounds_of(std::span<const Item> items) {
  Eigen::AlignedBox3d box;
  for (const Item& item : items) box.extend(bounds(*item.mesh));
  return box;
}

void check(const Options& options, const Eigen::AlignedBox3d& box) {
  const auto bad_side = [](int side) { return side < 16 || side > 8192; };
  if (bad_side(options.width) || bad_side(options.height)) {
    throw Error("size " + std::to_string(options.width) + "x" + std::to_string(options.height) +
                ": each side must have 16 to 8192 pixels");
  }
  if (options.camera) {
    const Camera& camera = *options.camera;
    if (!std::isfinite(camera.azimuth) || !(std::abs(camera.elevation) <= 90)) {
      throw Error("camera: elevation must be in [-90, 90] degrees");
    }
    if (!(camera.zoom > 0) || !std::isfinite(camera.zoom)) throw Error("camera: zoom must be positive");
  }
  if (box.isEmpty()) throw Error("nothing to draw: no mesh has a triangle");
  if (!options.cut) return;
  const int axis = static_cast<int>(options.cut->axis);
  const double low = box.min()[axis], high = box.max()[axis];
  if (!(options.cut->offset >= low && options.cut->offset <= high)) {
    throw Error(std::string("cut ") + "xyz"[axis] + "=" + std::to_string(options.cut->offset) +
                " is outside the bounds [" + std::to_string(low) + ", " + std::to_string(high) + "]");
  }
}

// What decides the distance of the camera: used vertices, and of a cut only the section and what is beyond it.
std::vector<Eigen::Vector3d> visible_points(std::span<const Item> items, const std::optional<Cut>& cut, double side) {
  std::vector<Eigen::Vector3d> points;
  for (const Item& item : items) {
    const TriangleMesh& mesh = *item.mesh;
    std::vector<char> used(static_cast<std::size_t>(mesh.vertices.rows()));
    for (std::int64_t i = 0; i < mesh.triangles.size(); ++i) used[mesh.triangles.data()[i]] = 1;
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(used.size()); ++v) {
      const Eigen::Vector3d p = mesh.vertex(v);
      const bool kept = !cut || side * (p[static_cast<int>(cut->axis)] - cut->offset) >= 0;
      if (used[v] && kept && item.style != Style::section) points.push_back(p);
    }
    if (!cut) continue;
    for (const Segment& s : slice(mesh, *cut)) points.push_back(s.start);
  }
  return points;
}

View make_view(std::span<const Item> items, const Options& options) {
  Camera camera;
  camera.up = options.up;
  if (options.cut) camera = camera_along(options.cut->axis, options.up);
  if (options.camera) camera = *options.camera;
  double side = 0;
  if (options.cut) {
    const int axis = static_cast<int>(options.cut->axis);
    const View from_far(camera, options.width, options.height, {Eigen::Vector3d::Zero()});
    side = from_far.forward()[axis];
    if (std::abs(side) < 1e-3) throw Error("camera: it looks along the plane of the cut");
  }
  std::vector<Eigen::Vector3d> points = visible_points(items, options.cut, side);
  if (points.empty()) points = visible_points(items, std::nullopt, 0);
  return View(camera, options.width, options.height, points);
}

}  // namespace

Image render(std::span<const Item> items, const Options& options) {
  const Eigen::AlignedBox3d box = bounds_of(items);
  check(options, box);
  const View view = make_view(items, options);
  return Renderer(items, options, view, box).draw();
}

}  // namespace encage::render
