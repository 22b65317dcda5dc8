// SPDX-License-Identifier: Apache-2.0
#include "src/asset/view.h"

#include "src/asset/glb.h"
#include "src/asset/index.h"
#include "src/asset/json.h"
#include "src/files/hash.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <climits>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <set>
#include <utility>

namespace encage {

const char* name(SectionKind kind) noexcept {
  switch (kind) {
    case SectionKind::cage: return "cage";
    case SectionKind::fine: return "fine";
  }
  return "";
}

namespace {

template <class Enum>
Enum enumerator(const JsonNode& node, std::initializer_list<Enum> all) {
  for (const Enum value : all) {
    if (node.text() == name(value)) return value;
  }
  node.fail("\"" + node.text() + "\" is unknown");
}

Certificate read_certificate(const JsonNode& level) {
  Certificate c;
  c.clearance = level.at("clearance").number();
  c.volume = level.at("volume").number();
  if (const auto ratio = level.find("volume_ratio")) c.volume_ratio = ratio->number();
  if (const auto distance = level.find("max_distance")) c.max_distance = distance->number();
  if (const auto distance = level.find("mean_distance")) c.mean_distance = distance->number();
  c.components = static_cast<int>(level.at("components").integer(0, INT_MAX));
  c.cavities = static_cast<int>(level.at("cavities").integer(0, INT_MAX));
  c.genus = static_cast<int>(level.at("genus").integer(0, INT_MAX));
  if (const auto handles = level.find("no_new_handles")) c.no_new_handles = handles->boolean();
  c.method = enumerator(level.at("method"), {Method::collapse, Method::flow, Method::hull});
  c.start = level.at("start").text();
  return c;
}

CageHierarchy read_description(const JsonNode& extension) {
  CageHierarchy h;
  const JsonNode origin = extension.at("origin");
  if (origin.size() != 3) origin.fail("has not 3 elements");
  for (int axis = 0; axis < 3; ++axis) h.origin[axis] = origin.at(std::int64_t{axis}).number();
  h.solid = enumerator(extension.at("solid"), {Solid::closed, Solid::capped, Solid::surface_only});
  h.source_hash = extension.at("source_hash").hash();
  h.source_volume = extension.at("source_volume").number();
  h.diagonal = extension.at("diagonal").number();
  h.cap_count = extension.at("cap_count").integer();
  h.fine_error = extension.at("fine_error").number();
  h.truncated = extension.at("truncated").boolean();
  if (const auto options = extension.find("options")) h.options = options->object().dump();
  const JsonNode levels = extension.at("levels");
  for (std::int64_t i = 0; i < levels.size(); ++i) {
    h.levels.push_back({.mesh = {}, .certificate = read_certificate(levels.at(i))});
  }
  return h;
}

/// The version is checked before anything else is read, because everything else may differ between versions.
JsonNode find_extension(const JsonNode& root) {
  const auto extensions = root.find("extensions");
  const auto extension = extensions ? extensions->find(asset_extension) : std::nullopt;
  if (!extension) root.fail(std::string("no extension ") + asset_extension + ": not an Encage asset");
  const std::int64_t version = extension->at("version").integer();
  if (version != asset_version) {
    extension->fail("format version " + std::to_string(version) + " is unknown, this program reads version " +
                    std::to_string(asset_version));
  }
  return *extension;
}

void check_seal(const Glb& glb, std::span<const std::byte> bytes, Verify verify, const std::string& file) {
  if (glb.head.size() % asset_alignment != 0) throw Error(file + ": BIN chunk: its data are not 64-byte aligned");
  if (glb.bin.size() < seal_size) throw Error(file + ": BIN chunk: too short for the seal");
  const std::string_view seal{reinterpret_cast<const char*>(glb.bin.last(seal_size).data()), seal_size};
  if (to_string(hash_bytes(glb.head)) != seal.substr(0, seal_hash_size)) {
    throw Error(file + ": JSON chunk: its hash does not match: the file is damaged");
  }
  if (verify == Verify::all &&
      to_string(hash_bytes(bytes.first(bytes.size() - seal_hash_size))) != seal.substr(seal_hash_size)) {
    throw Error(file + ": its hash does not match: the file is damaged");
  }
}

/// Returns the bytes that are read first: the seal, and the index unless it is very long.
std::span<const std::byte> last_part(std::span<const std::byte> bytes) {
  constexpr std::size_t likely_index = 4096;
  static_assert(likely_index >= seal_size);
  return bytes.last(std::min(likely_index, bytes.size()));
}

template <class T>
std::span<const T> elements(const AssetSection& section) {
  return {reinterpret_cast<const T*>(section.bytes.data()), section.bytes.size() / sizeof(T)};
}

}  // namespace

/// Finds sections and meshes in the parsed JSON.
class AssetView::Parser {
 public:
  Parser(const JsonNode& root, const JsonNode& extension, std::span<const std::byte> arrays)
      : root_(root), table_(extension.at("sections")), arrays_(arrays) {}

  std::vector<AssetSection> read_sections() {
    std::vector<AssetSection> sections;
    std::set<std::string> names;
    std::size_t end = 0;
    for (std::int64_t i = 0; i < table_.size(); ++i) {
      const JsonNode entry = table_.at(i);
      AssetSection section = read_section(entry, end);
      if (!names.insert(section.name).second) entry.fail("a second section \"" + section.name + "\"");
      end = static_cast<std::size_t>(section.bytes.data() - arrays_.data()) + section.bytes.size();
      sections.push_back(std::move(section));
    }
    return sections;
  }

  MeshView read_mesh(std::int64_t index, SectionKind kind, const std::vector<AssetSection>& sections) const {
    const JsonNode primitives = root_.at("meshes").at(index).at("primitives");
    if (primitives.size() != 1) primitives.fail("has not 1 element");
    const JsonNode primitive = primitives.at(std::int64_t{0});
    if (primitive.at("mode").integer() != 4) primitive.fail("its mode is not 4, triangles");
    MeshView mesh;
    const JsonNode positions = accessor(primitive.at("attributes").at("POSITION"), 5126, "VEC3");
    mesh.vertices = elements<std::array<float, 3>>(section_of(positions, kind, sections));
    check_count(positions, mesh.vertices.size());
    const JsonNode indices = accessor(primitive.at("indices"), 5125, "SCALAR");
    mesh.triangles = elements<std::array<std::uint32_t, 3>>(section_of(indices, kind, sections));
    check_count(indices, mesh.triangles.size() * 3);
    return mesh;
  }

 private:
  AssetSection read_section(const JsonNode& entry, std::size_t end_of_previous) const {
    AssetSection section;
    section.name = entry.at("name").text();
    section.kind = enumerator(entry.at("kind"), {SectionKind::cage, SectionKind::fine});
    section.hash = entry.at("hash").hash();
    const auto limit = static_cast<std::int64_t>(arrays_.size());
    const JsonNode view = root_.at("bufferViews").at(entry.at("bufferView").integer());
    if (view.at("buffer").integer() != 0) view.fail("not in the BIN chunk");
    const std::int64_t offset = view.at("byteOffset").integer(0, limit);
    const std::int64_t size = view.at("byteLength").integer(1, limit);
    if (size > limit - offset) view.fail("reaches beyond the BIN chunk");
    if (offset % asset_alignment != 0) view.fail("byteOffset is not 64-byte aligned");
    if (offset < static_cast<std::int64_t>(end_of_previous)) view.fail("overlaps the section before");
    const std::int64_t element_size = entry.at("element_size").integer(1);
    if (size % element_size != 0) view.fail("byteLength is no multiple of the section's element_size");
    section.element_size = static_cast<std::size_t>(element_size);
    section.bytes = arrays_.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(size));
    return section;
  }

  JsonNode accessor(const JsonNode& reference, std::int64_t component_type, const char* type) const {
    JsonNode found = root_.at("accessors").at(reference.integer());
    if (found.at("componentType").integer() != component_type) found.fail("unexpected componentType");
    if (found.at("type").text() != type) found.fail("unexpected type");
    if (found.find("byteOffset") || found.find("sparse")) found.fail("byteOffset and sparse are not allowed");
    return found;
  }

  /// Returns the section of the accessor's buffer view. Triangles and vertices both have 12 bytes.
  const AssetSection& section_of(const JsonNode& accessor, SectionKind kind,
                                 const std::vector<AssetSection>& sections) const {
    const JsonNode view = accessor.at("bufferView");
    for (std::size_t i = 0; i < sections.size(); ++i) {
      const JsonNode entry = table_.at(static_cast<std::int64_t>(i));
      if (entry.at("bufferView").integer() != view.integer()) continue;
      if (sections[i].element_size != 12) entry.fail("element_size is not 12");
      if (sections[i].kind != kind) entry.fail(std::string("kind is not \"") + name(kind) + "\"");
      return sections[i];
    }
    view.fail("is in no section");
  }

  static void check_count(const JsonNode& accessor, std::size_t count) {
    if (accessor.at("count").integer() != static_cast<std::int64_t>(count)) {
      accessor.fail("count does not match the section's size");
    }
  }

  JsonNode root_;
  JsonNode table_;
  std::span<const std::byte> arrays_;
};

AssetView::AssetView(const std::filesystem::path& file, Verify verify, LoadMode mode, AssetParts parts)
    : image_(file, mode), name_(file.string()) {
  image_.fetch(verify == Verify::all ? image_.bytes() : last_part(image_.bytes()));
  read(image_.bytes(), verify, parts);
}

AssetView::AssetView(std::span<const std::byte> bytes, const std::string& name, Verify verify, AssetParts parts)
    : name_(name) {
  assert(reinterpret_cast<std::uintptr_t>(bytes.data()) % asset_alignment == 0);
  read(bytes, verify, parts);
}

const CageHierarchy& AssetView::description() const {
  assert(description_);
  return *description_;
}

void AssetView::read(std::span<const std::byte> bytes, Verify verify, AssetParts parts) {
  if (parts == AssetParts::arrays && verify == Verify::cages && read_index(bytes)) return;
  if (verify == Verify::cages) fetch_head();
  parse(bytes, verify);
  summary_ = {description_->origin, description_->solid, description_->fine_error};
}

/// Reads everything before the BIN data, in one read where it is small.
void AssetView::fetch_head() {
  constexpr std::size_t likely_head = 8192;
  static_assert(likely_head >= glb_start);
  const std::span<const std::byte> all = image_.bytes();
  const auto fetch_first = [&](std::size_t size) { image_.fetch(all.first(std::min(size, all.size()))); };
  fetch_first(likely_head);
  if (const std::size_t size = glb_head_size(all); size > likely_head) fetch_first(size);
}

void AssetView::fetch_clearances() {
  if (!description_ && mode() != LoadMode::map && !image_.bytes().empty()) fetch_head();
}

std::vector<double> AssetView::clearances() const {
  std::vector<double> all;
  if (description_) {
    for (const CageLevel& level : description_->levels) all.push_back(level.certificate.clearance);
    return all;
  }
  const Glb glb = parse_glb(image_.bytes(), name_);
  check_seal(glb, image_.bytes(), Verify::cages, name_);
  const nlohmann::json document = parse_json(glb.json, name_ + ": JSON chunk");
  const CageHierarchy description = read_description(find_extension(JsonNode(document, name_ + ": JSON")));
  check_description(description, name_);
  for (const CageLevel& level : description.levels) all.push_back(level.certificate.clearance);
  if (all.size() != cages_.size()) throw Error(name_ + ": JSON: not as many levels as the index has");
  return all;
}

/// Reads everything from the first section of kind `cage` on; in files that this library writes, these are all such
/// sections.
void AssetView::fetch_cages() {
  const auto first = std::find_if(sections_.begin(), sections_.end(),
                                  [](const AssetSection& section) { return section.kind == SectionKind::cage; });
  const std::byte* const fetched = last_part(image_.bytes()).data();
  if (first != sections_.end() && first->bytes.data() < fetched) image_.fetch({first->bytes.data(), fetched});
}

/// Reads sections and meshes from the index. Returns false if there is none.
bool AssetView::read_index(std::span<const std::byte> bytes) {
  const auto found = find_index(bytes);
  if (!found) return false;
  if (!image_.bytes().empty()) image_.fetch(*found);  // the index may be longer than the bytes read so far
  const AssetIndex index = decode_index(*found, name_);
  const auto end = static_cast<std::size_t>(found->data() - bytes.data());
  std::size_t end_of_previous = 0;
  for (std::size_t m = 0; m < index.meshes.size(); ++m) {
    const bool is_fine = index.has_fine && m == 0;
    const std::string mesh_name = is_fine ? fine_name : cage_name(index.has_fine ? m - 1 : m);
    for (std::size_t k = 0; k < mesh_sections.size(); ++k) {
      const AssetIndex::Array& array = index.meshes[m][k];
      AssetSection& section = sections_.emplace_back();
      section.name = section_name(mesh_name, mesh_sections[k]);
      section.kind = is_fine ? SectionKind::fine : SectionKind::cage;
      section.element_size = mesh_sections[k].element_size;
      section.hash = array.hash;
      const std::size_t start = end - array.before;
      if (array.before > end || start < end_of_previous || start % asset_alignment != 0 || array.size == 0 ||
          array.size > array.before || array.size % section.element_size != 0) {
        throw Error(name_ + ": section \"" + index_name + "\": \"" + section.name + "\" cannot be where it says");
      }
      section.bytes = bytes.subspan(start, array.size);
      end_of_previous = start + array.size;
    }
  }
  if (!image_.bytes().empty()) fetch_cages();
  for (std::size_t m = 0; m < index.meshes.size(); ++m) {
    const AssetSection* const arrays = &sections_[m * mesh_sections.size()];
    const MeshView mesh = {elements<std::array<float, 3>>(arrays[0]),
                           elements<std::array<std::uint32_t, 3>>(arrays[1])};
    if (arrays->kind == SectionKind::fine) {
      fine_ = mesh;
      continue;
    }
    for (std::size_t k = 0; k < mesh_sections.size(); ++k) verify_hash(arrays[k]);
    check_mesh(mesh, name_ + ": " + cage_name(cages_.size()));
    cages_.push_back(mesh);
  }
  summary_ = {index.origin, index.solid, index.fine_error};
  return true;
}

/// Checks that an index, if there is one, is the one that loading finds, and that it agrees with the JSON.
void AssetView::check_index(std::span<const std::byte> bytes) const {
  const std::string place = name_ + ": section \"" + index_name + "\": ";
  const AssetSection* const section = find_section(index_name);
  const auto found = find_index(bytes);
  if (!section && !found) return;
  if (!section) throw Error(place + "before the seal, but not among the sections");
  if (!found || found->data() != section->bytes.data() || found->size() != section->bytes.size()) {
    throw Error(place + "it is not what is before the seal");
  }
  AssetIndex index;
  index.file_size = static_cast<std::uint32_t>(bytes.size());
  index.origin = description_->origin;
  index.fine_error = description_->fine_error;
  index.solid = description_->solid;
  index.has_fine = fine_.has_value();
  const std::size_t count = cages_.size() + (fine_ ? 1 : 0);
  for (std::size_t m = 0; m < count; ++m) {
    const std::string mesh_name = fine_ && m == 0 ? fine_name : cage_name(fine_ ? m - 1 : m);
    const MeshView& view = fine_ && m == 0 ? *fine_ : cages_[fine_ ? m - 1 : m];
    const std::array<const void*, 2> starts = {view.vertices.data(), view.triangles.data()};
    AssetIndex::Mesh& mesh = index.meshes.emplace_back();
    for (std::size_t k = 0; k < mesh_sections.size(); ++k) {
      const auto array_name = [&] { return section_name(mesh_name, mesh_sections[k]); };
      const AssetSection* const array = find_section(array_name());
      if (!array) throw Error(place + "there is no section \"" + array_name() + "\"");
      if (k < starts.size() && starts[k] != array->bytes.data()) {
        throw Error(place + "section \"" + array_name() + "\" is not what the mesh has");
      }
      mesh[k] = {static_cast<std::uint32_t>(section->bytes.data() - array->bytes.data()),
                 static_cast<std::uint32_t>(array->bytes.size()), array->hash};
    }
  }
  const std::string expected = encode_index(index);
  if (std::ranges::equal(std::as_bytes(std::span(expected)), section->bytes)) return;
  const AssetIndex stored = decode_index(section->bytes, name_);
  for (std::size_t m = 0; m < std::min(count, stored.meshes.size()); ++m) {
    for (std::size_t k = 0; k < mesh_sections.size(); ++k) {
      const AssetIndex::Array &is = stored.meshes[m][k], &should = index.meshes[m][k];
      if (is.before == should.before && is.size == should.size && is.hash == should.hash) continue;
      const std::string mesh_name = fine_ && m == 0 ? fine_name : cage_name(fine_ ? m - 1 : m);
      throw Error(place + "of \"" + section_name(mesh_name, mesh_sections[k]) +
                  "\" it does not say what the JSON says");
    }
  }
  throw Error(place + "its last 64 bytes do not say what the JSON says");
}

void AssetView::parse(std::span<const std::byte> bytes, Verify verify) {
  const Glb glb = parse_glb(bytes, name_);
  const nlohmann::json document = parse_json(glb.json, name_ + ": JSON chunk");
  const JsonNode root(document, name_ + ": JSON");
  const JsonNode extension = find_extension(root);
  check_seal(glb, bytes, verify, name_);

  Parser parser(root, extension, glb.bin.first(glb.bin.size() - seal_size));
  sections_ = parser.read_sections();
  if (verify == Verify::cages && !image_.bytes().empty()) fetch_cages();
  for (const AssetSection& section : sections_) {
    if (section.kind == SectionKind::cage || verify == Verify::all) verify_hash(section);
  }
  description_ = read_description(extension);
  check_description(*description_, name_);

  std::int64_t next_mesh = 0;
  if (const auto fine = extension.find("fine_mesh")) {
    fine_ = parser.read_mesh(fine->integer(), SectionKind::fine, sections_);
    check_caps(description_->cap_count, static_cast<std::int64_t>(fine_->triangles.size()), name_);
    next_mesh = fine->integer() + 1;
  }
  for (std::size_t i = 0; i < description_->levels.size(); ++i) {
    const JsonNode mesh = extension.at("levels").at(static_cast<std::int64_t>(i)).at("mesh");
    if (mesh.integer() < next_mesh) mesh.fail("the meshes do not go from fine to coarse");
    cages_.push_back(parser.read_mesh(mesh.integer(), SectionKind::cage, sections_));
    next_mesh = mesh.integer() + 1;
    check_mesh(cages_.back(), name_ + ": " + cage_name(i));
  }
  if (verify == Verify::all) check_index(bytes);
}

std::optional<MeshView> AssetView::fine() const {
  if (fine_) check_mesh(*fine_, name_ + ": " + fine_name);
  return fine_;
}

std::optional<MeshArraysView> AssetView::cage_arrays(std::size_t level) const {
  return arrays(cages_[level], cage_name(level));
}

std::optional<MeshArraysView> AssetView::fine_arrays() const { return arrays(*fine_, fine_name); }

std::optional<MeshArraysView> AssetView::arrays(const MeshView& mesh, const std::string& mesh_name) const {
  const auto named = [&](std::size_t k) { return section_name(mesh_name, mesh_sections[k]); };
  if (!find_section(named(2))) return std::nullopt;
  const MeshArraysView view = {mesh,
                               {array<MeshNode>(named(2)), array<LeafTriangle>(named(3)), make_grid(mesh.vertices)},
                               array<OwnedFeatures>(named(4)),
                               array<MeshPart>(named(5))};
  check_arrays(view, name_ + ": " + mesh_name);
  return view;
}

template <class T>
std::span<const T> AssetView::array(const std::string& section_name) const {
  const AssetSection* section = find_section(section_name);
  if (!section) throw Error(name_ + ": no section \"" + section_name + "\"");
  if (section->element_size != sizeof(T)) {
    throw Error(name_ + ": section \"" + section_name + "\": its elements have " +
                std::to_string(section->element_size) + " bytes, not " + std::to_string(sizeof(T)));
  }
  return elements<T>(*section);
}

const AssetSection* AssetView::find_section(std::string_view section_name) const {
  const auto found = std::find_if(sections_.begin(), sections_.end(),
                                  [&](const AssetSection& section) { return section.name == section_name; });
  return found == sections_.end() ? nullptr : &*found;
}

/// Calls act(bytes) for each maximal run of adjacent sections of kind `fine`.
template <class Do>
void AssetView::for_each_fine_run(Do&& act) const {
  const auto is_fine = [](const AssetSection& section) { return section.kind == SectionKind::fine; };
  for (auto first = sections_.begin(); first != sections_.end();) {
    first = std::find_if(first, sections_.end(), is_fine);
    if (first == sections_.end()) return;
    const auto end = std::find_if_not(first, sections_.end(), is_fine);
    const std::byte* const start = first->bytes.data();
    const AssetSection& last = *std::prev(end);
    act(std::span(start, last.bytes.data() + last.bytes.size()));
    first = end;
  }
}

std::int64_t AssetView::fine_bytes() const noexcept {
  std::int64_t sum = 0;
  for_each_fine_run([&](std::span<const std::byte> bytes) { sum += static_cast<std::int64_t>(bytes.size()); });
  return sum;
}

void AssetView::fetch_fine() {
  for_each_fine_run([&](std::span<const std::byte> bytes) { image_.fetch(bytes); });
}

void AssetView::verify_fine() const {
  for (const AssetSection& section : sections_) {
    if (section.kind == SectionKind::fine) verify_hash(section);
  }
}

void AssetView::discard_fine() noexcept {
  for_each_fine_run([&](std::span<const std::byte> bytes) { image_.discard(bytes); });
}

void AssetView::verify_hash(const AssetSection& section) const {
  if (hash_bytes(section.bytes) == section.hash) return;
  throw Error(name_ + ": section \"" + section.name + "\": its hash does not match: the file is damaged");
}

}  // namespace encage
