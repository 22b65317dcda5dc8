// SPDX-License-Identifier: Apache-2.0
#include "src/files/atomic_file.h"
#include "src/files/number_text.h"
#include "src/limits.h"

#include <encage/poses.h>

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>

namespace encage {
namespace {

constexpr std::string_view header = "step,body,x,y,z,qx,qy,qz,qw";
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // in UTF-8, which spreadsheets write
constexpr std::array<const char*, 9> column = {"step", "body", "x", "y", "z", "qx", "qy", "qz", "qw"};

struct Row {
  std::int64_t step = 0;
  BodyPose body;
};

/// Parses one line; every message starts with "file:line: ".
class RowParser {
 public:
  RowParser(std::string_view line, std::string where) : rest_(line), where_(std::move(where)) {}

  Row parse() {
    Row row;
    row.step = number<std::int64_t>();
    row.body.body = number<std::int32_t>();
    if (row.step < 0) fail("step is negative");
    if (row.body.body < 0) fail("body is negative");
    std::array<double, 7> v{};
    for (double& x : v) {
      x = number<double>();
      if (!std::isfinite(x)) fail(std::string(column[next_ - 1]) + " is not finite");
      if (std::abs(x) > largest_length)
        fail(std::string(column[next_ - 1]) + " is " + number_text(x) + ", beyond 1e150");
    }
    if (next_ != column.size() || more_) fail("more than 9 columns");
    Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (const double length = q.norm(); !(std::abs(length - 1) <= 1e-6)) {
      fail("the quaternion's length is " + number_text(length) + ", not 1");
    }
    q.normalize();
    row.body.pose.linear() = q.toRotationMatrix();
    row.body.pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    return row;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const { throw Error(where_ + reason); }

  template <class T>
  T number() {
    const char* name = column[next_++];
    if (!more_) fail(std::string("column ") + name + " is missing");
    const std::size_t comma = rest_.find(',');
    const std::string_view field = rest_.substr(0, comma);
    more_ = comma != std::string_view::npos;
    rest_.remove_prefix(more_ ? comma + 1 : rest_.size());
    T value{};
    const char* end = field.data() + field.size();
    const auto [stop, error] = std::from_chars(field.data(), end, value);
    if (error != std::errc{} || stop != end) {
      fail(std::string("column ") + name + " is not a number in range: '" + std::string(field) + "'");
    }
    return value;
  }

  std::string_view rest_;
  std::string where_;
  std::size_t next_ = 0;
  bool more_ = true;
};

void strip_carriage_return(std::string& line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
}

void append_row(std::vector<PoseStep>& steps, const Row& row, const std::string& where) {
  if (!steps.empty() && row.step < steps.back().step) throw Error(where + "steps do not increase");
  if (steps.empty() || row.step > steps.back().step) steps.push_back({row.step, {}});
  std::vector<BodyPose>& bodies = steps.back().bodies;
  if (!bodies.empty() && row.body.body <= bodies.back().body) {
    throw Error(where + "bodies do not increase within the step");
  }
  bodies.push_back(row.body);
}

template <class T>
void append(std::string& text, T value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
}

}  // namespace

std::vector<PoseStep> read_poses(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) throw Error(file.string() + ": cannot be read");
  std::string line;
  if (!std::getline(in, line)) throw Error(file.string() + ": empty file");
  if (line.starts_with(byte_order_mark)) line.erase(0, byte_order_mark.size());
  strip_carriage_return(line);
  if (line != header) throw Error(file.string() + ":1: the header is not '" + std::string(header) + "'");
  std::vector<PoseStep> steps;
  for (std::int64_t number = 2; std::getline(in, line); ++number) {
    strip_carriage_return(line);
    const std::string where = file.string() + ":" + std::to_string(number) + ": ";
    append_row(steps, RowParser(line, where).parse(), where);
  }
  if (in.bad()) throw Error(file.string() + ": cannot be read");
  if (steps.empty()) throw Error(file.string() + ": no poses");
  return steps;
}

void write_poses(const std::filesystem::path& file, const std::vector<PoseStep>& steps) {
  std::string text(header);
  text += '\n';
  for (const PoseStep& step : steps) {
    for (const BodyPose& body : step.bodies) {
      append(text, step.step);
      text += ',';
      append(text, body.body);
      const Eigen::Quaterniond q(body.pose.linear());
      for (const double x : {body.pose.translation().x(), body.pose.translation().y(), body.pose.translation().z(),
                             q.x(), q.y(), q.z(), q.w()}) {
        text += ',';
        append(text, x);
      }
      text += '\n';
    }
  }
  write_atomically(file, text);
}

}  // namespace encage
