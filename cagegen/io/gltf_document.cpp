// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/gltf_document.h"

#include "cagegen/io/gltf_draco.h"
#include "cagegen/io/gltf_meshopt.h"
#include "cagegen/io/mesh_file.h"
#include "src/files/file_image.h"

#include <encage/error.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace encage::io {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

constexpr const char* meshopt_names[] = {"KHR_meshopt_compression", "EXT_meshopt_compression"};

/// Extensions that move no vertex of the default pose and hide none, and those that GltfDocument and read_gltf() obey.
/// Names that end in '_' stand for all that begin so.
constexpr std::string_view known_extensions[] = {
    // The reader obeys these.
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    // These change the looks.
    "ADOBE_materials_",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_texture_",
    "KHR_environment_map",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_technique_webgl",
    "KHR_techniques_webgl",
    "KHR_texture_",
    "MSFT_packing_",
    "MSFT_texture_",
    "NV_materials_mdl",
    "VRMC_materials_",
    // These move things later than in the default pose.
    "KHR_animation_pointer",
    "KHR_interactivity",
    // These say more about the same triangles.
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "KHR_audio_",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
};

bool is_known(std::string_view extension) {
  return std::any_of(std::begin(known_extensions), std::end(known_extensions), [&](std::string_view known) {
    return known.ends_with('_') ? extension.starts_with(known) : extension == known;
  });
}

template <typename T>
T load_as(const std::uint8_t* data) {
  T value;
  std::memcpy(&value, data, sizeof(T));
  return value;
}

GltfDocument::Bytes as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// 0 for an unknown type.
std::size_t component_size(GltfComponent type) {
  switch (type) {
    case GltfComponent::int8:
    case GltfComponent::uint8: return 1;
    case GltfComponent::int16:
    case GltfComponent::uint16: return 2;
    case GltfComponent::uint32:
    case GltfComponent::float32: return 4;
    default: return 0;
  }
}

bool is_index(GltfComponent type) {
  return type == GltfComponent::uint8 || type == GltfComponent::uint16 || type == GltfComponent::uint32;
}

const char* component_name(GltfComponent type) {
  switch (type) {
    case GltfComponent::int8: return "signed bytes";
    case GltfComponent::uint8: return "unsigned bytes";
    case GltfComponent::int16: return "signed shorts";
    case GltfComponent::uint16: return "unsigned shorts";
    case GltfComponent::uint32: return "unsigned integers";
    default: return "floats";
  }
}

int component_count(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC3") return 3;
  return type == "VEC4" ? 4 : 16;  // MAT4
}

/// Calls `use` with a value of the C++ type.
template <typename Use>
void with_component(GltfComponent type, const Use& use) {
  switch (type) {
    case GltfComponent::int8: return use(std::int8_t{});
    case GltfComponent::uint8: return use(std::uint8_t{});
    case GltfComponent::int16: return use(std::int16_t{});
    case GltfComponent::uint16: return use(std::uint16_t{});
    case GltfComponent::uint32: return use(std::uint32_t{});
    default: return use(float{});
  }
}

/// Decodes base64; no value if the text is none.
std::optional<std::string> decode_base64(std::string_view text) {
  while (text.ends_with('=')) text.remove_suffix(1);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    std::uint32_t digit = 0;
    if (c >= 'A' && c <= 'Z') {
      digit = static_cast<std::uint32_t>(c - 'A');
    } else if (c >= 'a' && c <= 'z') {
      digit = static_cast<std::uint32_t>(c - 'a' + 26);
    } else if (c >= '0' && c <= '9') {
      digit = static_cast<std::uint32_t>(c - '0' + 52);
    } else if (c == '+' || c == '/') {
      digit = c == '+' ? 62 : 63;
    } else {
      return std::nullopt;
    }
    bits = bits << 6 | digit;
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      bytes += static_cast<char>(bits >> bit_count & 0xFF);
    }
  }
  return bytes;
}

/// Resolves the "%20" of a URI.
std::string decode_percent(std::string_view uri) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool escaped = uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0;
    text += escaped ? static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2])) : uri[i];
    i += escaped ? 2 : 0;
  }
  return text;
}

/// The scheme of a URI, as "https"; empty for a path. One letter is a drive.
std::string_view scheme_of(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  if (colon == uri.npos || colon < 2) return {};
  const bool is_scheme = std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '+' || c == '-' ||
           c == '.';
  });
  return is_scheme ? uri.substr(0, colon) : std::string_view();
}

}  // namespace

/// The elements of an accessor: `count` of them, `stride` bytes apart.
struct GltfDocument::Elements {
  std::int64_t accessor = 0;
  const std::uint8_t* data = nullptr;
  std::size_t stride = 0;
  std::int64_t count = 0;
  GltfComponent component = GltfComponent::float32;
  int width = 1;  ///< components
  bool normalized = false;
  std::vector<std::uint8_t> copy;  ///< what `data` points to where no buffer has it

  std::size_t size() const { return component_size(component) * static_cast<std::size_t>(width); }
};

std::optional<JsonNode> find_extension(const JsonNode& element, const char* name) {
  const std::optional<JsonNode> extensions = element.find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

GltfDocument::GltfDocument(const std::filesystem::path& file, std::string_view bytes)
    : file_(file), bytes_read_(static_cast<std::int64_t>(bytes.size())) {
  const std::string_view text = open_container(bytes);
  if (json_depth(text) > max_json_depth) {
    fail(file_, "JSON nested deeper than " + std::to_string(max_json_depth) + " levels");
  }
  json_ = parse_json(text, file_.string() + ": JSON");
  check_version();
  check_extensions();
}

/// The JSON of a file. That of a binary one stands in its first chunk, and the data of one buffer in the second.
std::string_view GltfDocument::open_container(std::string_view bytes) {
  constexpr std::size_t header = 12, chunk_header = 8;
  if (!bytes.starts_with("glTF")) return bytes;
  const Bytes all = as_bytes(bytes);
  if (all.size() < header + chunk_header) {
    fail(file_, "GLB header: the file has only " + std::to_string(all.size()) + " bytes");
  }
  const auto word = [&](std::size_t offset) { return load_as<std::uint32_t>(all.data() + offset); };
  if (word(4) == 1) {
    fail(file_, "binary glTF 1.0 is not supported; convert it to glTF 2.0, for example with gltf-pipeline");
  }
  if (word(4) != 2) fail(file_, "GLB header: glTF version " + std::to_string(word(4)) + " is not 2");
  const std::size_t length = word(8);
  if (length > all.size()) {
    fail(file_, "GLB header: the length " + std::to_string(length) + " exceeds the file's " +
                    std::to_string(all.size()) + " bytes");
  }
  std::optional<std::string_view> json;
  for (std::size_t at = header; at + chunk_header <= length;) {
    const std::size_t size = word(at);
    if (size > length - at - chunk_header) {
      fail(file_, "GLB chunk: its length " + std::to_string(size) + " exceeds the " +
                      std::to_string(length - at - chunk_header) + " bytes left in the file");
    }
    const std::string_view content = bytes.substr(at + chunk_header, size);
    const std::string_view kind = bytes.substr(at + 4, 4);
    if (!json && kind != "JSON") fail(file_, "GLB chunk: the first one is not JSON");
    if (!json) {
      json = content;
    } else if (!chunk_ && kind == std::string_view("BIN\0", 4)) {
      chunk_ = as_bytes(content);
    }
    at += chunk_header + size;
  }
  if (!json) fail(file_, "GLB header: the length " + std::to_string(length) + " leaves no room for JSON");
  return *json;
}

void GltfDocument::check_version() const {
  constexpr const char* remedy = " is not supported; convert it to glTF 2.0, for example with gltf-pipeline";
  if (!json_.is_object()) fail(file_, "JSON: not an object");
  // Up to version 1.0, elements have names instead of numbers.
  const auto meshes = json_.find("meshes");
  const auto asset = json_.find("asset");
  const std::string version =
      asset != json_.end() && asset->is_object() && asset->contains("version")
          ? (asset->at("version").is_string() ? asset->at("version").get<std::string>() : asset->at("version").dump())
          : std::string();
  if (version.starts_with("0") || version.starts_with("1") ||
      (version.empty() && meshes != json_.end() && meshes->is_object())) {
    fail(file_, "glTF " + (version.empty() ? "1.0" : version) + remedy);
  }
  if (version.empty()) fail(file_, "not a glTF file: asset.version is missing");
  const std::optional<JsonNode> least = root().at("asset").find("minVersion");
  if (version != "2" && !version.starts_with("2.")) fail(file_, "glTF " + version + remedy);
  if (least && least->text() != "2.0") fail(file_, "glTF " + least->text() + remedy);
}

void GltfDocument::check_extensions() const {
  const std::optional<JsonNode> required = root().find("extensionsRequired");
  std::string unknown;
  std::int64_t unknown_count = 0;
  for (std::int64_t i = 0; required && i < required->size(); ++i) {
    const std::string& extension = required->at(i).text();
    if (extension == draco_extension && !has_draco()) {
      fail(file_, "the file requires the extension " + extension + ", " + no_draco);
    }
    if (is_known(extension)) continue;
    unknown += (unknown_count++ == 0 ? "" : ", ") + extension;
  }
  if (unknown_count == 0) return;
  fail(file_, std::string("the file requires the extension") + (unknown_count == 1 ? " " : "s ") + unknown +
                  ", which Encage does not know; save it without");
}

bool GltfDocument::requires_extension(std::string_view name) const {
  const auto required = json_.find("extensionsRequired");
  return required != json_.end() && std::find(required->begin(), required->end(), name) != required->end();
}

std::int64_t GltfDocument::count(const char* array) const {
  const std::optional<JsonNode> found = root().find(array);
  return found ? found->size() : 0;
}

JsonNode GltfDocument::element(const char* array, const char* word, std::int64_t number) const {
  return JsonNode(json_.at(array).at(static_cast<std::size_t>(number)),
                  file_.string() + ": " + word + ' ' + std::to_string(number));
}

JsonNode GltfDocument::element(const char* array, const char* word, const JsonNode& reference) const {
  const std::int64_t number = reference.integer();
  if (number >= count(array)) reference.fail("there is no " + (word + (' ' + std::to_string(number))));
  return element(array, word, number);
}

bool GltfDocument::has_data(std::int64_t buffer) const {
  return json_.at("buffers").at(static_cast<std::size_t>(buffer)).contains("uri") || (buffer == 0 && chunk_);
}

GltfDocument::Bytes GltfDocument::buffer(const JsonNode& reference) {
  const JsonNode node = element("buffers", "buffer", reference);
  const std::int64_t number = reference.integer();
  const auto length = static_cast<std::size_t>(node.at("byteLength").integer());
  if (!has_data(number)) node.fail("has no data: neither a URI nor a chunk of a binary file");
  Bytes bytes;
  if (node.find("uri")) {
    auto [loaded, is_new] = buffers_.try_emplace(number);
    if (is_new) {
      loaded->second = load(node);
      bytes_read_ += static_cast<std::int64_t>(loaded->second.size());
    }
    bytes = as_bytes(loaded->second);
  } else {
    bytes = *chunk_;
  }
  if (bytes.size() < length) {
    node.fail("has " + std::to_string(bytes.size()) + " bytes, byteLength promises " + std::to_string(length));
  }
  return bytes.first(length);
}

/// The data that a buffer's URI stands for.
std::string GltfDocument::load(const JsonNode& buffer) const {
  const std::string_view uri = buffer.at("uri").text();
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(',');
    if (comma == uri.npos || !uri.substr(0, comma).ends_with(";base64")) buffer.fail("the data URI is not base64");
    std::optional<std::string> bytes = decode_base64(uri.substr(comma + 1));
    if (!bytes) buffer.fail("the data URI has a character that is not base64");
    return *std::move(bytes);
  }
  if (!scheme_of(uri).empty()) {
    buffer.fail("its data are at '" + std::string(uri) +
                "', not in a file; put them beside this file and name them by a path");
  }
  const std::filesystem::path path = file_.parent_path() / decode_percent(uri);
  try {
    FileImage image(path, LoadMode::copy);
    image.fetch(image.bytes());
    return {reinterpret_cast<const char*>(image.bytes().data()), image.bytes().size()};
  } catch (const Error& error) {
    buffer.fail(error.what());
  }
}

GltfDocument::Bytes GltfDocument::view(const JsonNode& reference) {
  const JsonNode node = element("bufferViews", "buffer view", reference);
  const JsonNode in = node.at("buffer");
  const JsonNode holder = element("buffers", "buffer", in);
  const std::int64_t number = reference.integer();
  const auto length = static_cast<std::size_t>(node.at("byteLength").integer());
  for (const char* const name : meshopt_names) {
    const std::optional<JsonNode> extension = find_extension(node, name);
    if (!extension) continue;
    // A file that merely uses the extension may have the plain bytes too.
    const std::optional<JsonNode> mark = find_extension(holder, name);
    const bool plain = has_data(in.integer()) && !(mark && mark->find("fallback") && mark->at("fallback").boolean());
    if (plain && !requires_extension(name)) continue;
    auto found = decompressed_.find(number);
    if (found == decompressed_.end()) found = decompressed_.emplace(number, decompress(*extension)).first;
    if (length > found->second.size()) {
      node.fail("has " + std::to_string(length) + " bytes, " + name + " decompresses to " +
                std::to_string(found->second.size()));
    }
    return Bytes(found->second).first(length);
  }
  const Bytes all = buffer(in);
  const auto offset = static_cast<std::size_t>(node.find("byteOffset") ? node.at("byteOffset").integer() : 0);
  if (offset > all.size() || length > all.size() - offset) {
    node.fail("reaches beyond buffer " + std::to_string(in.integer()));
  }
  return all.subspan(offset, length);
}

std::vector<std::uint8_t> GltfDocument::decompress(const JsonNode& extension) {
  const Bytes all = buffer(extension.at("buffer"));
  const auto offset = static_cast<std::size_t>(extension.find("byteOffset") ? extension.at("byteOffset").integer() : 0);
  const auto length = static_cast<std::size_t>(extension.at("byteLength").integer());
  if (offset > all.size() || length > all.size() - offset) {
    extension.fail("reaches beyond buffer " + std::to_string(extension.at("buffer").integer()));
  }
  const Bytes bytes = all.subspan(offset, length);
  const std::string& mode = extension.at("mode").text();
  const std::string filter = extension.find("filter") ? extension.at("filter").text() : "NONE";
  const auto stride = static_cast<std::size_t>(extension.at("byteStride").integer(1, 256));
  const auto count = static_cast<std::size_t>(extension.at("count").integer(1));
  const bool attributes = mode == "ATTRIBUTES";
  if (!attributes && mode != "TRIANGLES" && mode != "INDICES") extension.fail("the mode '" + mode + "' is unknown");
  const bool fits = attributes ? stride % 4 == 0 : stride == 2 || stride == 4;
  if (!fits) extension.fail("byteStride " + std::to_string(stride) + " does not go with the mode " + mode);
  if (mode == "TRIANGLES" && count % 3 != 0) {
    extension.fail("count " + std::to_string(count) + " is no whole number of triangles");
  }
  if (!attributes && filter != "NONE") extension.fail("the filter " + filter + " does not go with the mode " + mode);
  // Many views may name the same data.
  constexpr std::size_t largest_vertex = 16;
  if (count > (largest_vertex * static_cast<std::size_t>(plausible_size()) - decompressed_bytes_) / stride) {
    extension.fail("the compressed data unfold to more than a file of this size can mean");
  }
  std::optional<std::vector<std::uint8_t>> result = decode_meshopt(attributes            ? MeshoptMode::attributes
                                                                   : mode == "TRIANGLES" ? MeshoptMode::triangles
                                                                                         : MeshoptMode::indices,
                                                                   bytes, count, stride);
  if (!result) extension.fail("the compressed data are damaged");
  if (!apply_meshopt_filter(filter, *result, stride)) {
    extension.fail("the filter " + filter + " is unknown, or does not go with byteStride " + std::to_string(stride));
  }
  decompressed_bytes_ += result->size();
  return *std::move(result);
}

/// So many elements of such a type, in the buffer view and at the offset that `data` names.
GltfDocument::Elements GltfDocument::strided(const JsonNode& reference, const JsonNode& data, Elements elements) {
  const JsonNode in = data.at("bufferView");
  const Bytes bytes = view(in);
  const auto offset = static_cast<std::size_t>(data.find("byteOffset") ? data.at("byteOffset").integer() : 0);
  const std::optional<JsonNode> stride = element("bufferViews", "buffer view", in).find("byteStride");
  const std::size_t size = elements.size();
  elements.stride = stride ? static_cast<std::size_t>(stride->integer()) : 0;
  if (elements.stride == 0) elements.stride = size;
  // Every term is compared before it is used: the numbers come from the file.
  const bool inside =
      elements.count == 0 ||
      (elements.stride >= size && offset <= bytes.size() && size <= bytes.size() - offset &&
       static_cast<std::size_t>(elements.count - 1) <= (bytes.size() - offset - size) / elements.stride);
  if (!inside) {
    reference.fail("accessor " + std::to_string(elements.accessor) + " reaches beyond buffer view " +
                   std::to_string(in.integer()));
  }
  elements.data = elements.count == 0 ? nullptr : bytes.data() + offset;
  return elements;
}

GltfDocument::Elements GltfDocument::elements(const JsonNode& reference, const char* type) {
  const JsonNode node = accessor(reference);
  const std::string name = "accessor " + std::to_string(reference.integer());
  if (node.at("type").text() != type) reference.fail(name + " is " + node.at("type").text() + ", not " + type);
  const auto component = static_cast<GltfComponent>(node.at("componentType").integer());
  if (component_size(component) == 0) {
    reference.fail(name + " has the unknown component type " + std::to_string(node.at("componentType").integer()));
  }
  const std::int64_t count = node.at("count").integer();
  const std::optional<JsonNode> normalized = node.find("normalized");
  Elements result;
  result.accessor = reference.integer();
  result.count = count;
  result.component = component;
  result.width = component_count(type);
  if (node.find("bufferView")) result = strided(reference, node, result);
  result.normalized = normalized && normalized->boolean();
  // Without data of their own or compressed, elements take no bytes of the file. A triangle has three indices.
  if (count > plausible_size() * (result.width == 1 ? 3 : 1)) {
    reference.fail(name + " has more elements than a file of this size can mean");
  }
  const std::optional<JsonNode> sparse = node.find("sparse");
  if (sparse) {
    change(reference, *sparse, result);
  } else if (!node.find("bufferView")) {
    own(result);
  }
  return result;
}

/// Copies the elements, zeros where no buffer has them.
void GltfDocument::own(Elements& elements) {
  const std::size_t size = elements.size();
  std::vector<std::uint8_t> copy(static_cast<std::size_t>(elements.count) * size);
  for (std::size_t i = 0; elements.data != nullptr && i < static_cast<std::size_t>(elements.count); ++i) {
    std::memcpy(copy.data() + i * size, elements.data + i * elements.stride, size);
  }
  elements.copy = std::move(copy);
  elements.data = elements.copy.data();
  elements.stride = size;
}

/// Replaces the elements that a sparse accessor lists.
void GltfDocument::change(const JsonNode& reference, const JsonNode& sparse, Elements& elements) {
  const std::string name = "accessor " + std::to_string(elements.accessor);
  Elements values = elements, indices = elements;
  values.count = indices.count = sparse.at("count").integer();
  indices.component = static_cast<GltfComponent>(sparse.at("indices").at("componentType").integer());
  indices.width = 1;
  if (!is_index(indices.component)) reference.fail(name + " has sparse indices that are no unsigned integers");
  indices = strided(reference, sparse.at("indices"), indices);
  values = strided(reference, sparse.at("values"), values);
  own(elements);
  with_component(indices.component, [&](auto index) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(indices.count); ++i) {
      index = load_as<decltype(index)>(indices.data + i * indices.stride);
      if (static_cast<double>(index) >= static_cast<double>(elements.count)) {
        reference.fail(name + " has the sparse index " + std::to_string(index) + ", but only " +
                       std::to_string(elements.count) + " elements");
      }
      std::memcpy(elements.copy.data() + static_cast<std::size_t>(index) * elements.stride,
                  values.data + i * values.stride, elements.stride);
    }
  });
}

std::vector<double> GltfDocument::numbers(const JsonNode& reference, const char* type, Components components) {
  const Elements from = elements(reference, type);
  const bool allowed = from.component == GltfComponent::float32 ||
                       (from.component != GltfComponent::uint32 &&
                        (components == Components::any || (components == Components::normalized && from.normalized)));
  if (!allowed) {
    reference.fail("accessor " + std::to_string(from.accessor) + " has " + (from.normalized ? "normalized " : "") +
                   component_name(from.component) + ", which are not allowed here");
  }
  std::vector<double> result;
  result.reserve(static_cast<std::size_t>(from.count * from.width));
  with_component(from.component, [&](auto component) {
    using Component = decltype(component);
    // Both -128 and -127 stand for -1 (glTF 2.0, section 3.6.2.2).
    const bool fraction = from.normalized && from.component != GltfComponent::float32;
    const double largest = fraction ? static_cast<double>(std::numeric_limits<Component>::max()) : 1;
    for (std::size_t i = 0; i < static_cast<std::size_t>(from.count); ++i) {
      for (int k = 0; k < from.width; ++k) {
        const auto value = static_cast<double>(load_as<Component>(from.data + i * from.stride + k * sizeof(Component)));
        result.push_back(fraction ? std::max(value / largest, -1.0) : value);
      }
    }
  });
  return result;
}

std::vector<std::int64_t> GltfDocument::integers(const JsonNode& reference, const char* type) {
  const Elements from = elements(reference, type);
  if (!is_index(from.component) || from.normalized) {
    reference.fail("accessor " + std::to_string(from.accessor) + " has " + (from.normalized ? "normalized " : "") +
                   component_name(from.component) + " instead of plain unsigned ones");
  }
  std::vector<std::int64_t> result;
  result.reserve(static_cast<std::size_t>(from.count * from.width));
  with_component(from.component, [&](auto component) {
    using Component = decltype(component);
    for (std::size_t i = 0; i < static_cast<std::size_t>(from.count); ++i) {
      for (int k = 0; k < from.width; ++k) {
        result.push_back(
            static_cast<std::int64_t>(load_as<Component>(from.data + i * from.stride + k * sizeof(Component))));
      }
    }
  });
  return result;
}

}  // namespace encage::io
