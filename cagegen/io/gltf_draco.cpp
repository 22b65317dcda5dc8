// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/gltf_draco.h"

#include <string>

#ifdef ENCAGE_WITH_DRACO
#include <draco/compression/decode.h>

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>
#include <utility>
#endif

namespace encage::io {

#ifdef ENCAGE_WITH_DRACO

bool has_draco() noexcept { return true; }

struct DracoMesh::Decoded {
  std::unique_ptr<draco::Mesh> mesh;
};

DracoMesh::DracoMesh(std::span<const std::uint8_t> bytes) : decoded_(std::make_unique<Decoded>()) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!mesh.ok()) throw DracoError("Draco cannot decompress the data: " + mesh.status().error_msg_string());
  decoded_->mesh = std::move(mesh).value();
}

DracoMesh::~DracoMesh() = default;
DracoMesh::DracoMesh(DracoMesh&& other) noexcept = default;
DracoMesh& DracoMesh::operator=(DracoMesh&& other) noexcept = default;

std::int64_t DracoMesh::vertex_count() const { return decoded_->mesh->num_points(); }

std::vector<std::int64_t> DracoMesh::corners() const {
  std::vector<std::int64_t> corners;
  corners.reserve(std::size_t{3} * decoded_->mesh->num_faces());
  for (draco::FaceIndex f(0); f < decoded_->mesh->num_faces(); ++f) {
    for (const draco::PointIndex& point : decoded_->mesh->face(f)) {
      if (point.value() >= decoded_->mesh->num_points()) {
        throw DracoError("Draco's triangle " + std::to_string(f.value()) + " has a vertex out of range");
      }
      corners.push_back(point.value());
    }
  }
  return corners;
}

namespace {

template <typename T>
std::vector<double> values_of(const draco::Mesh& mesh, const draco::PointAttribute& attribute, bool normalized) {
  const std::size_t width = attribute.num_components(), stride = static_cast<std::size_t>(attribute.byte_stride());
  const bool fraction = normalized && std::is_integral_v<T>;
  std::vector<double> numbers;
  numbers.reserve(width * mesh.num_points());
  std::vector<T> values(std::max(width, (stride + sizeof(T) - 1) / sizeof(T)));
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex index = attribute.mapped_index(point);
    if (index.value() >= attribute.size()) {
      throw DracoError("Draco's vertex " + std::to_string(point.value()) + " has no value");
    }
    attribute.GetValue(index, values.data());
    for (std::size_t k = 0; k < width; ++k) {
      const auto number = static_cast<double>(values[k]);
      numbers.push_back(fraction ? std::max(number / static_cast<double>(std::numeric_limits<T>::max()), -1.0)
                                 : number);
    }
  }
  return numbers;
}

}  // namespace

std::vector<double> DracoMesh::attribute(std::int64_t id, int width, bool normalized) const {
  const draco::Mesh& mesh = *decoded_->mesh;
  const draco::PointAttribute* const found = mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
  if (found == nullptr) throw DracoError("Draco's data have no attribute " + std::to_string(id));
  if (found->num_components() != width) {
    throw DracoError("Draco's attribute " + std::to_string(id) + " has " + std::to_string(found->num_components()) +
                     " components, not " + std::to_string(width));
  }
  switch (found->data_type()) {
    case draco::DT_INT8: return values_of<std::int8_t>(mesh, *found, normalized);
    case draco::DT_UINT8: return values_of<std::uint8_t>(mesh, *found, normalized);
    case draco::DT_INT16: return values_of<std::int16_t>(mesh, *found, normalized);
    case draco::DT_UINT16: return values_of<std::uint16_t>(mesh, *found, normalized);
    case draco::DT_INT32: return values_of<std::int32_t>(mesh, *found, normalized);
    case draco::DT_UINT32: return values_of<std::uint32_t>(mesh, *found, normalized);
    case draco::DT_FLOAT32: return values_of<float>(mesh, *found, normalized);
    case draco::DT_FLOAT64: return values_of<double>(mesh, *found, normalized);
    default: throw DracoError("Draco's attribute " + std::to_string(id) + " has a type that glTF does not know");
  }
}

#else

bool has_draco() noexcept { return false; }

struct DracoMesh::Decoded {};

DracoMesh::DracoMesh(std::span<const std::uint8_t>) {
  throw DracoError(std::string("it is compressed with ") + draco_extension + ", " + no_draco);
}

DracoMesh::~DracoMesh() = default;
DracoMesh::DracoMesh(DracoMesh&& other) noexcept = default;
DracoMesh& DracoMesh::operator=(DracoMesh&& other) noexcept = default;

std::int64_t DracoMesh::vertex_count() const { return 0; }
std::vector<std::int64_t> DracoMesh::corners() const { return {}; }
std::vector<double> DracoMesh::attribute(std::int64_t, int, bool) const { return {}; }

#endif

}  // namespace encage::io
