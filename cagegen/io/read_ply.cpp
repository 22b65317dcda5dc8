// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/text_scanner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace encage::io {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr struct {
  const char* name;
  const char* other_name;
  Type type;
  int size;
} types[] = {
    {"char", "int8", Type::int8, 1},        {"uchar", "uint8", Type::uint8, 1},
    {"short", "int16", Type::int16, 2},     {"ushort", "uint16", Type::uint16, 2},
    {"int", "int32", Type::int32, 4},       {"uint", "uint32", Type::uint32, 4},
    {"float", "float32", Type::float32, 4}, {"double", "float64", Type::float64, 8},
};

struct Property {
  std::string name;
  Type type = Type::float64;
  bool is_list = false;
  Type count_type = Type::uint8;
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

enum class Format { ascii, little_endian, big_endian };

struct PlyHeader {
  Format format = Format::ascii;
  std::vector<Element> elements;
};

/// Reads the header and leaves in `bytes` what follows it.
class HeaderReader {
 public:
  HeaderReader(const std::filesystem::path& file, std::string_view& bytes) : file_(file), bytes_(bytes) {}

  PlyHeader read() {
    if (words() != std::vector<std::string>{"ply"}) fail("not a PLY file");
    PlyHeader header;
    bool has_format = false;
    for (;;) {
      const std::vector<std::string> line = words();
      if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
      if (line[0] == "end_header") break;
      if (line[0] == "format") {
        if (has_format) fail("a second 'format'");
        header.format = format(line);
        has_format = true;
      } else if (line[0] == "element" && line.size() == 3) {
        header.elements.push_back(element(line, header.elements));
      } else if (line[0] == "property" && !header.elements.empty()) {
        header.elements.back().properties.push_back(property(line));
      } else {
        fail("cannot understand '" + line[0] + "'");
      }
    }
    if (!has_format) fail("'format' is missing");
    skip_line_end(header.format);
    return header;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    io::fail(file_, "header line " + std::to_string(line_) + ": " + reason);
  }

  /// The words of the next line, which ends in LF, CR LF or CR.
  std::vector<std::string> words() {
    if (line_ > 0) skip_line_end(Format::ascii);
    ++line_;
    const std::size_t end = bytes_.find_first_of("\r\n");
    if (end == bytes_.npos) fail("the header ends early");
    TextScanner scanner(file_, bytes_.substr(0, end));
    bytes_.remove_prefix(end);
    std::vector<std::string> result;
    for (std::string_view t = scanner.token_on_line(); !t.empty(); t = scanner.token_on_line()) result.emplace_back(t);
    return result;
  }

  /// Behind a header whose lines end in CR, an LF is the first byte of binary data.
  void skip_line_end(Format next) {
    const bool two = bytes_.starts_with("\r\n") && (next == Format::ascii || has_line_feeds_);
    has_line_feeds_ |= two || bytes_[0] == '\n';
    bytes_.remove_prefix(two ? 2 : 1);
  }

  Format format(const std::vector<std::string>& line) const {
    if (line.size() < 2) fail("'format' without a name");
    if (line[1] == "ascii") return Format::ascii;
    if (line[1] == "binary_little_endian") return Format::little_endian;
    if (line[1] == "binary_big_endian") return Format::big_endian;
    fail("unknown format '" + line[1] + "'");
  }

  Element element(const std::vector<std::string>& line, const std::vector<Element>& before) const {
    Element result{line[1], 0, {}};
    if (!parse_integer(line[2], result.count) || result.count < 0) fail("bad number of '" + line[1] + "'");
    for (const Element& other : before) {
      if (other.name == result.name) fail("a second element '" + line[1] + "'");
    }
    return result;
  }

  Type type(const std::string& name) const {
    for (const auto& t : types) {
      if (name == t.name || name == t.other_name) return t.type;
    }
    fail("unknown type '" + name + "'");
  }

  Property property(const std::vector<std::string>& line) const {
    if (line.size() == 5 && line[1] == "list") return {line[4], type(line[3]), true, type(line[2])};
    if (line.size() == 3) return {line[2], type(line[1]), false, Type::uint8};
    fail("cannot understand this property");
  }

  const std::filesystem::path& file_;
  std::string_view& bytes_;
  std::int64_t line_ = 0;
  bool has_line_feeds_ = false;
};

std::int64_t count_of(const PlyHeader& header, std::string_view name) {
  for (const Element& element : header.elements) {
    if (element.name == name) return element.count;
  }
  return 0;
}

/// Values one after the other, in text or in binary.
class Body {
 public:
  Body(const std::filesystem::path& file, std::string_view bytes, const PlyHeader& header)
      : file_(file),
        bytes_(bytes),
        format_(header.format),
        vertices_(count_of(header, "vertex")),
        scanner_(file, bytes) {}

  /// What follows holds no more values.
  std::size_t most_values() const { return bytes_.size() - at_; }

  double value(Type type, const char* element, std::int64_t number) {
    if (format_ == Format::ascii) {
      double result = 0;
      const std::string_view token = scanner_.token();
      if (token.empty()) ends_early(element, number);
      if (!parse_number(token, result)) {
        io::fail(file_, element, number, "'" + std::string(token.substr(0, 40)) + "' is not a number");
      }
      return result;
    }
    switch (type) {
      case Type::int8: return binary<std::int8_t>(element, number);
      case Type::uint8: return binary<std::uint8_t>(element, number);
      case Type::int16: return binary<std::int16_t>(element, number);
      case Type::uint16: return binary<std::uint16_t>(element, number);
      case Type::int32: return binary<std::int32_t>(element, number);
      case Type::uint32: return binary<std::uint32_t>(element, number);
      case Type::float32: return binary<float>(element, number);
      case Type::float64: return binary<double>(element, number);
    }
    return 0;
  }

  /// How many values a property has.
  std::int64_t count(const Property& property, const char* element, std::int64_t number) {
    if (!property.is_list) return 1;
    const std::int64_t result = integer(property.count_type, element, number);
    if (result < 0) io::fail(file_, element, number, "a list of " + std::to_string(result) + " values");
    return result;
  }

  /// In text, every element has a line of its own, or several.
  void end_element(const char* element, std::int64_t number) {
    if (format_ != Format::ascii) return;
    const std::string_view token = scanner_.token_on_line();
    if (token.empty()) return;
    io::fail(file_, element, number,
             "line " + std::to_string(scanner_.line()) + " of the data goes on with " + quoted(token) +
                 ", which the header does not promise");
  }

  /// Throws if there is more. A line end behind binary data does no harm.
  void end() {
    const std::string_view rest = bytes_.substr(at_);
    if (format_ == Format::ascii ? scanner_.token().empty() : rest.find_first_not_of("\r\n") == rest.npos) return;
    io::fail(file_, format_ == Format::ascii
                        ? "line " + std::to_string(scanner_.line()) + " of the data is more than the header promises"
                        : "the data is " + counted(static_cast<std::int64_t>(rest.size()), "byte", "bytes") +
                              " longer than the header promises");
  }

  /// Counts and indices: a number without fraction.
  std::int64_t integer(Type type, const char* element, std::int64_t number) {
    const double result = value(type, element, number);
    if (!(std::abs(result) <= 0x1p53) || result != std::trunc(result)) {
      io::fail(file_, element, number, "expected an integer");
    }
    return static_cast<std::int64_t>(result);
  }

  /// An integer that can be the index of a vertex, or -1.
  std::int32_t index(Type type, const char* element, std::int64_t number) {
    const std::int64_t result = integer(type, element, number);
    if (result < INT32_MIN || result > INT32_MAX) out_of_range(element, number, result);
    return static_cast<std::int32_t>(result);
  }

  [[noreturn]] void out_of_range(const char* element, std::int64_t number, std::int64_t index) const {
    io::fail(file_, element, number,
             "vertex index " + std::to_string(index) + " is out of range (" + std::to_string(vertices_) + " vertices)");
  }

 private:
  [[noreturn]] void ends_early(const char* element, std::int64_t number) const {
    io::fail(file_, element, number, "the file ends early: the header promises more");
  }

  template <typename T>
  T binary(const char* element, std::int64_t number) {
    if (bytes_.size() - at_ < sizeof(T)) ends_early(element, number);
    char raw[sizeof(T)];
    const bool swapped = (format_ == Format::big_endian) != (std::endian::native == std::endian::big);
    for (std::size_t i = 0; i < sizeof(T); ++i) raw[swapped ? sizeof(T) - 1 - i : i] = bytes_[at_ + i];
    at_ += sizeof(T);
    T result;
    std::memcpy(&result, raw, sizeof(T));
    return result;
  }

  const std::filesystem::path& file_;
  std::string_view bytes_;
  Format format_;
  std::int64_t vertices_;
  TextScanner scanner_;
  std::size_t at_ = 0;
};

void read_vertices(const std::filesystem::path& file, const Element& element, Body& body, Soup& soup) {
  static constexpr const char* names[3] = {"x", "y", "z"};
  std::vector<int> axis(element.properties.size(), -1);
  for (int k = 0; k < 3; ++k) {
    bool found = false;
    for (std::size_t p = 0; p < axis.size() && !found; ++p) {
      found = element.properties[p].name == names[k] && !element.properties[p].is_list;
      if (found) axis[p] = k;
    }
    if (!found) fail(file, std::string("the vertices have no property '") + names[k] + "'");
  }
  for (std::int64_t v = 0; v < element.count; ++v) {
    double point[3] = {0, 0, 0};
    for (std::size_t p = 0; p < axis.size(); ++p) {
      const Property& property = element.properties[p];
      const std::int64_t values = body.count(property, "vertex", v);
      for (std::int64_t i = 0; i < values; ++i) {
        const double value = body.value(property.type, "vertex", v);
        if (axis[p] >= 0) point[axis[p]] = value;
      }
    }
    body.end_element("vertex", v);
    soup.coordinates.insert(soup.coordinates.end(), point, point + 3);
  }
}

/// The number of the list that holds corners; that of all properties if there is none.
std::size_t corner_list(const Element& element) {
  const std::vector<Property>& all = element.properties;
  const auto found = std::find_if(all.begin(), all.end(), [](const Property& property) {
    return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
  });
  return static_cast<std::size_t>(found - all.begin());
}

/// Reads an element and hands on the values of one of its lists, which are indices of vertices.
template <class Use>
void read_lists(const Element& element, std::size_t list, const char* name, Body& body, const Use& use) {
  std::vector<std::int32_t> values;
  for (std::int64_t e = 0; e < element.count; ++e) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      const std::int64_t count = body.count(property, name, e);
      if (p == list) {
        values.clear();
        values.reserve(plausible_count(count, body.most_values()));
      }
      for (std::int64_t i = 0; i < count; ++i) {
        if (p == list) {
          values.push_back(body.index(property.type, name, e));
        } else {
          body.value(property.type, name, e);
        }
      }
    }
    body.end_element(name, e);
    use(e, values);
  }
}

void read_faces(const std::filesystem::path& file, const Element& element, Body& body, Soup& soup) {
  const std::size_t list = corner_list(element);
  if (list == element.properties.size()) fail(file, "the faces have no list 'vertex_indices'");
  read_lists(element, list, "face", body, [&](std::int64_t, const std::vector<std::int32_t>& corners) {
    soup.corners.insert(soup.corners.end(), corners.begin(), corners.end());
    soup.end_polygon();
  });
}

/// Triangles of consecutive corners, every other one turned; -1 begins another strip.
void add_strips(const std::vector<std::int32_t>& indices, Soup& soup) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] == -1) begin = i + 1;
    if (i < begin + 2) continue;
    std::array<std::int32_t, 3> corners = {indices[i - 2], indices[i - 1], indices[i]};
    if ((i - begin) % 2 == 1) std::swap(corners[0], corners[1]);
    // Writers repeat corners to go on elsewhere; what lies between is no part of the surface.
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    soup.corners.insert(soup.corners.end(), corners.begin(), corners.end());
    soup.end_polygon();
  }
}

/// Indices are checked here: faces cannot tell from which strip they are.
void read_strips(const std::filesystem::path& file, const Element& element, std::int64_t vertices, Body& body,
                 Soup& soup) {
  const std::size_t list = corner_list(element);
  if (list == element.properties.size()) fail(file, "the triangle strips have no list 'vertex_indices'");
  read_lists(element, list, "triangle strip", body, [&](std::int64_t s, const std::vector<std::int32_t>& indices) {
    for (const std::int32_t index : indices) {
      if (index >= -1 && index < vertices) continue;
      body.out_of_range("triangle strip", s, index);
    }
    add_strips(indices, soup);
  });
}

/// Reads what is no surface.
void skip(const Element& element, Body& body, Soup& soup) {
  read_lists(element, element.properties.size(), element.name.c_str(), body, [](auto&&...) {});
  if (element.count > 0 && corner_list(element) < element.properties.size()) {
    soup.notes.push_back("skipped: " + std::to_string(element.count) + " of element '" + element.name +
                         "', which are no faces");
  }
}

}  // namespace

Soup read_ply(const std::filesystem::path& file, std::string_view bytes) {
  require_utf8(file, bytes);
  Soup soup;
  if (has_byte_order_mark(bytes)) soup.notes.emplace_back(byte_order_mark_note);
  const PlyHeader header = HeaderReader(file, bytes).read();
  Body body(file, bytes, header);
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;
    if (element.name == "vertex") {
      soup.coordinates.reserve(plausible_count(element.count, bytes.size() / 3) * 3);
      read_vertices(file, element, body, soup);
    } else if (element.name == "face") {
      soup.first.reserve(plausible_count(element.count, bytes.size()) + 1);
      read_faces(file, element, body, soup);
    } else if (element.name == "tristrips") {
      read_strips(file, element, count_of(header, "vertex"), body, soup);
    } else {
      skip(element, body, soup);
    }
  }
  body.end();
  return soup;
}

}  // namespace encage::io
