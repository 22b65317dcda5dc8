// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/text_scanner.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <string>

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
    PlyHeader header;
    if (words() != std::vector<std::string>{"ply"}) fail("not a PLY file");
    const std::vector<std::string> format = words();
    if (format.size() < 2 || format[0] != "format") fail("expected 'format'");
    if (format[1] == "binary_little_endian") {
      header.format = Format::little_endian;
    } else if (format[1] == "binary_big_endian") {
      header.format = Format::big_endian;
    } else if (format[1] != "ascii") {
      fail("unknown format '" + format[1] + "'");
    }
    for (;;) {
      const std::vector<std::string> line = words();
      if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
      if (line[0] == "end_header") return header;
      if (line[0] == "element" && line.size() == 3) {
        header.elements.push_back({line[1], 0, {}});
        if (!parse_integer(line[2], header.elements.back().count) || header.elements.back().count < 0) {
          fail("bad number of '" + line[1] + "'");
        }
      } else if (line[0] == "property" && !header.elements.empty()) {
        header.elements.back().properties.push_back(property(line));
      } else {
        fail("cannot understand '" + line[0] + "'");
      }
    }
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    io::fail(file_, "header line " + std::to_string(line_) + ": " + reason);
  }

  std::vector<std::string> words() {
    ++line_;
    const std::size_t end = bytes_.find('\n');
    if (end == bytes_.npos) fail("the header ends early");
    TextScanner scanner(file_, bytes_.substr(0, end));
    bytes_.remove_prefix(end + 1);
    std::vector<std::string> result;
    for (std::string_view t = scanner.token_on_line(); !t.empty(); t = scanner.token_on_line()) result.emplace_back(t);
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
};

/// Values one after the other, in text or in binary.
class Body {
 public:
  Body(const std::filesystem::path& file, std::string_view bytes, Format format)
      : file_(file), bytes_(bytes), format_(format), scanner_(file, bytes) {}

  double value(Type type, const char* element, std::int64_t number) {
    if (format_ == Format::ascii) {
      double result = 0;
      const std::string_view token = scanner_.token();
      if (token.empty()) io::fail(file_, element, number, "the file ends early");
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

  /// Counts and indices: a number without fraction.
  std::int64_t integer(Type type, const char* element, std::int64_t number) {
    const double result = value(type, element, number);
    if (!(std::abs(result) <= 0x1p53) || result != std::trunc(result)) {
      io::fail(file_, element, number, "expected an integer");
    }
    return static_cast<std::int64_t>(result);
  }

 private:
  template <typename T>
  T binary(const char* element, std::int64_t number) {
    if (bytes_.size() - at_ < sizeof(T)) io::fail(file_, element, number, "the file ends early");
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
      const std::int64_t values = property.is_list ? body.integer(property.count_type, "vertex", v) : 1;
      for (std::int64_t i = 0; i < values; ++i) {
        const double value = body.value(property.type, "vertex", v);
        if (axis[p] >= 0) point[axis[p]] = value;
      }
    }
    soup.coordinates.insert(soup.coordinates.end(), point, point + 3);
  }
}

void read_faces(const std::filesystem::path& file, const Element& element, Body& body, Soup& soup) {
  std::size_t indices = element.properties.size();
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const Property& property = element.properties[p];
    if (property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index")) indices = p;
  }
  if (indices == element.properties.size()) fail(file, "the faces have no list 'vertex_indices'");
  for (std::int64_t f = 0; f < element.count; ++f) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      const std::int64_t values = property.is_list ? body.integer(property.count_type, "face", f) : 1;
      for (std::int64_t i = 0; i < values; ++i) {
        if (p == indices) {
          soup.corners.push_back(body.integer(property.type, "face", f));
        } else {
          body.value(property.type, "face", f);
        }
      }
    }
    soup.end_polygon();
  }
}

void skip(const Element& element, Body& body) {
  for (std::int64_t e = 0; e < element.count; ++e) {
    for (const Property& property : element.properties) {
      const std::int64_t values = property.is_list ? body.integer(property.count_type, "element", e) : 1;
      for (std::int64_t i = 0; i < values; ++i) body.value(property.type, "element", e);
    }
  }
}

}  // namespace

Soup read_ply(const std::filesystem::path& file, std::string_view bytes) {
  const PlyHeader header = HeaderReader(file, bytes).read();
  Body body(file, bytes, header.format);
  Soup soup;
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;
    if (element.name == "vertex") {
      soup.coordinates.reserve(plausible_count(element.count, bytes.size() / 3) * 3);
      read_vertices(file, element, body, soup);
    } else if (element.name == "face") {
      soup.first.reserve(plausible_count(element.count, bytes.size()) + 1);
      read_faces(file, element, body, soup);
    } else {
      skip(element, body);
    }
  }
  return soup;
}

}  // namespace encage::io
