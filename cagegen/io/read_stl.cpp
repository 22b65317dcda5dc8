// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/text_scanner.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace encage::io {
namespace {

constexpr std::size_t header_size = 84;
constexpr std::size_t record_size = 50;

bool is_word(std::string_view token, std::string_view lower) {
  if (token.size() != lower.size()) return false;
  for (std::size_t i = 0; i < token.size(); ++i) {
    if ((token[i] | 0x20) != lower[i]) return false;
  }
  return true;
}

std::uint32_t promised_count(std::string_view bytes) {
  std::uint32_t count;
  std::memcpy(&count, bytes.data() + header_size - sizeof count, sizeof count);
  return count;
}

bool is_comment(std::string_view token) { return token.starts_with(';') || token.starts_with("//"); }

/// Whether a text begins with "solid", behind blank and comment lines.
bool begins_with_solid(const std::filesystem::path& file, std::string_view bytes) {
  TextScanner scanner(file, bytes);
  std::string_view token = scanner.token();
  while (is_comment(token)) {
    scanner.skip_line();
    token = scanner.token();
  }
  return is_word(token.substr(0, 5), "solid");
}

/// Binary files may begin with "solid" as well: the size tells, then a zero byte.
bool is_binary(const std::filesystem::path& file, std::string_view bytes) {
  if (bytes.size() >= header_size && bytes.size() == header_size + record_size * promised_count(bytes)) return true;
  require_utf8(file, bytes);
  return bytes.substr(0, 1024).find('\0') != bytes.npos || !begins_with_solid(file, bytes);
}

/// The number of triangles; adds notes where header and size disagree.
std::size_t record_count(const std::filesystem::path& file, std::string_view bytes, Soup& soup) {
  if (bytes.size() < header_size) fail(file, "not an STL file: too short for a header");
  const std::size_t promised = promised_count(bytes);
  const std::size_t present = (bytes.size() - header_size) / record_size,
                    rest = (bytes.size() - header_size) % record_size;
  if (present == promised && rest == 0) return present;
  // Programs that write as they go leave the count at 0, or at -1.
  if ((promised == 0 || promised == UINT32_MAX) && rest == 0) {
    soup.notes.push_back("the header gives no number of triangles; by the file's size there are " +
                         std::to_string(present));
    return present;
  }
  if (promised > present || promised == 0 || rest == 0) {
    fail(file, "the header promises " + std::to_string(promised) + " triangles, the file holds " +
                   std::to_string(present) + (rest > 0 ? " and " + std::to_string(rest) + " bytes more" : ""));
  }
  const std::size_t behind = bytes.size() - header_size - promised * record_size;
  soup.notes.push_back("skipped: " + std::to_string(behind) + " bytes behind the last of the " +
                       std::to_string(promised) + " triangles that the header promises");
  return promised;
}

void read_binary(const std::filesystem::path& file, std::string_view bytes, Soup& soup) {
  const std::size_t count = record_count(file, bytes, soup);
  soup.coordinates.reserve(count * 9);
  for (std::size_t t = 0; t < count; ++t) {
    float corners[9];
    std::memcpy(corners, bytes.data() + header_size + t * record_size + 12, sizeof corners);
    for (const float x : corners) {
      if (!std::isfinite(x)) fail(file, "face", static_cast<std::int64_t>(t), "coordinate is not finite");
      soup.coordinates.push_back(x);
    }
  }
}

/// Reads text, and notes what is not quite STL but means only one thing.
class TextStlReader {
 public:
  TextStlReader(const std::filesystem::path& file, std::string_view bytes, Soup& soup)
      : scanner_(file, bytes), soup_(soup) {}

  void read() {
    bool in_solid = false;
    for (std::string_view word = keyword(); !word.empty(); word = keyword()) {
      if (is_word(word, "solid")) {
        lacks_end_ |= in_solid;
        in_solid = true;
        scanner_.skip_line();
      } else if (in_solid && is_word(word, "endsolid")) {
        in_solid = false;
        scanner_.skip_line();
      } else if (in_solid && is_word(word, "facet")) {
        read_facet();
      } else {
        scanner_.fail(in_solid ? "expected 'facet' or 'endsolid'" : "expected 'solid'");
      }
    }
    lacks_end_ |= in_solid;
    add_notes();
  }

 private:
  /// The next word that is neither in a comment nor in a line of colour. "end loop" is one word, "endloop".
  std::string_view keyword() {
    for (;;) {
      const std::string_view word = scanner_.token();
      if (is_comment(word)) {
        has_comments_ = true;
        scanner_.skip_line();
      } else if (is_word(word, "color") || is_word(word, "colour")) {
        has_colours_ = true;
        scanner_.skip_line();
      } else if (is_word(word, "end")) {
        const std::string_view what = scanner_.token_on_line();
        for (const std::string_view one : {"endloop", "endfacet", "endsolid"}) {
          if (!is_word(what, one.substr(3))) continue;
          has_two_words_ = true;
          return one;
        }
        return word;
      } else {
        return word;
      }
    }
  }

  void expect(std::string_view word) {
    const std::string_view found = keyword();
    if (found.empty()) scanner_.fail("face", face_, "the file ends early");
    if (!is_word(found, word)) scanner_.fail("face", face_, "expected '" + std::string(word) + "'");
  }

  void read_facet() {
    scanner_.skip_line();  // normal
    expect("outer");
    expect("loop");
    for (int corner = 0; corner < 3; ++corner) {
      expect("vertex");
      for (int k = 0; k < 3; ++k) soup_.coordinates.push_back(scanner_.coordinate(scanner_.token(), "face", face_));
    }
    expect("endloop");
    expect("endfacet");
    ++face_;
  }

  void add_notes() {
    std::string skipped;
    const auto add = [&](bool found, const char* what) {
      if (found) skipped += (skipped.empty() ? "skipped: " : ", ") + std::string(what);
    };
    add(scanner_.found_byte_order_mark(), "a byte order mark");
    add(has_comments_, "comment lines");
    add(has_colours_, "colours");
    if (!skipped.empty()) soup_.notes.push_back(skipped);
    if (has_two_words_) soup_.notes.emplace_back("'end loop' and the like, in two words, were read as one");
    if (lacks_end_) soup_.notes.emplace_back("'endsolid' is missing; see whether the file was cut off");
  }

  TextScanner scanner_;
  Soup& soup_;
  std::int64_t face_ = 0;
  bool has_comments_ = false, has_colours_ = false, has_two_words_ = false, lacks_end_ = false;
};

}  // namespace

Soup read_stl(const std::filesystem::path& file, std::string_view bytes) {
  Soup soup;
  if (is_binary(file, bytes)) {
    read_binary(file, bytes, soup);
  } else {
    TextStlReader(file, bytes, soup).read();
  }
  if (soup.vertex_count() > INT32_MAX) fail(file, "more than 2^31 - 1 corners");
  // STL repeats every vertex in each of its triangles.
  soup.corners.reserve(static_cast<std::size_t>(soup.vertex_count()));
  for (std::int64_t v = 0; v < soup.vertex_count(); ++v) {
    soup.corners.push_back(static_cast<std::int32_t>(v));
    if (v % 3 == 2) soup.end_polygon();
  }
  share_vertices(soup);
  return soup;
}

}  // namespace encage::io
