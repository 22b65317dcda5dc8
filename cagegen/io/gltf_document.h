// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "src/asset/json.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// The JSON of a glTF 2.0 file and the numbers behind it. Debian's TinyGLTF is not used: it takes the data chunk of a
// binary file for every buffer that has no data, so that compressed bytes become vertices; it refuses indices without a
// buffer view, as Draco's are; and its messages name neither elements nor wrong types.

namespace encage::io {

/// The type of the numbers of an accessor. The values are those of OpenGL, as in the files.
enum class GltfComponent : std::int64_t { int8 = 5120, uint8, int16, uint16, uint32 = 5125, float32 };

/// A glTF 2.0 file, text or binary. It reads buffers, and decompresses buffer views, when something asks for them: what
/// is no geometry may be missing or damaged. A reference is the JSON integer that names an element; what is wrong with
/// the element's data is said at the place of the reference. All functions throw Error.
class GltfDocument {
 public:
  using Bytes = std::span<const std::uint8_t>;
  enum class Components {
    floats,      ///< float32
    normalized,  ///< or normalized integers of 8 or 16 bits, which become fractions
    any,         ///< or plain ones
  };

  /// Parses the container and the JSON. Before anything else it refuses other versions of glTF, and by name the
  /// extensions that the file requires and Encage does not know. `file` and `bytes` have to outlive the document.
  GltfDocument(const std::filesystem::path& file, std::string_view bytes);

  /// The top level; its place is "FILE: JSON".
  JsonNode root() const { return JsonNode(json_, file_.string() + ": JSON"); }
  bool requires_extension(std::string_view name) const;

  /// The length of an array of the top level, 0 if there is none.
  std::int64_t count(const char* array) const;
  /// An element of such an array; its place is "FILE: WORD NUMBER".
  JsonNode element(const char* array, const char* word, std::int64_t number) const;
  JsonNode element(const char* array, const char* word, const JsonNode& reference) const;

  /// The bytes of a buffer view, decompressed where they are compressed. They live as long as the document.
  Bytes view(const JsonNode& reference);

  JsonNode accessor(const JsonNode& reference) const { return element("accessors", "accessor", reference); }
  /// The elements of an accessor of this type ("VEC3"), component by component.
  std::vector<double> numbers(const JsonNode& reference, const char* type, Components components);
  /// The same for unsigned integers.
  std::vector<std::int64_t> integers(const JsonNode& reference, const char* type);

  /// An upper bound of the vertices and of the triangles that files of this size stand for. Instances and compression
  /// let a small file claim more than memory holds; files that mean it are far below.
  std::int64_t plausible_size() const { return (std::int64_t{1} << 18) + 64 * bytes_read_; }

 private:
  struct Elements;

  std::string_view open_container(std::string_view bytes);
  void check_version() const;
  void check_extensions() const;
  Bytes buffer(const JsonNode& reference);
  std::string load(const JsonNode& buffer) const;
  bool has_data(std::int64_t buffer) const;
  std::vector<std::uint8_t> decompress(const JsonNode& extension);
  Elements elements(const JsonNode& reference, const char* type);
  Elements strided(const JsonNode& reference, const JsonNode& data, Elements elements);
  void change(const JsonNode& reference, const JsonNode& sparse, Elements& elements);
  static void own(Elements& elements);

  const std::filesystem::path& file_;
  nlohmann::json json_;
  std::optional<Bytes> chunk_;  ///< the data in a binary file
  std::int64_t bytes_read_ = 0;
  std::map<std::int64_t, std::string> buffers_;
  std::map<std::int64_t, std::vector<std::uint8_t>> decompressed_;  ///< by buffer view
  std::size_t decompressed_bytes_ = 0;
};

/// An extension of an element.
std::optional<JsonNode> find_extension(const JsonNode& element, const char* name);

}  // namespace encage::io
