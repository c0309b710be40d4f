#include "files/path/print_job_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include "files/json.h"
#include "files/nearest.h"
#include "files/path/csv_columns.h"
#include "files/separated_values.h"
#include "files/usage_error.h"

namespace firn {
namespace {

using Json = nlohmann::json;

constexpr double kMaxCoordinate_mm = 1e5;

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw UsageError(where + ": " + what);
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf())) fail(file.string(), "cannot be read");
  return text.str();
}

void check_keys(const Json& object, const std::vector<std::string_view>& known, const std::string& where) {
  if (!object.is_object()) fail(where, "must be an object");
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string near = nearest(key, known);
    fail(where + "." + key.substr(0, 60),
         "unknown key" + (near.empty() ? std::string() : "; the nearest known one is " + near));
  }
}

double number(const Json& value, const std::string& where, double limit) {
  if (!value.is_number()) fail(where, "must be a number");
  const double v = value.get<double>();
  if (!(std::abs(v) <= limit)) fail(where, fmt::format("{} must lie within +-{}", v, limit));
  return v;
}

Point2 point(const Json& value, const std::string& where) {
  if (!value.is_array() || value.size() != 2) fail(where, "must be [x, y] in mm");
  return {number(value[0], where + "[0]", kMaxCoordinate_mm),
          number(value[1], where + "[1]", kMaxCoordinate_mm)};
}

const Json& required(const Json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) fail(where, fmt::format("has no key \"{}\"", key));
  return *found;
}

PrintJob from_json(const std::string& text, const std::string& name) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& e) {
    fail(name, fmt::format("byte {}: is no JSON", e.byte));
  }
  check_keys(json, {"start", "end", "segments"}, name);
  const Json& segments = required(json, "segments", name);
  if (!segments.is_array() || segments.empty())
    fail(name + ": segments", "must be a list with at least one segment");
  PrintJob job;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const std::string where = fmt::format("{}: segments[{}]", name, n);
    check_keys(segments[n], {"from", "to", "speed_mm_s"}, where);
    job.segments.push_back({point(required(segments[n], "from", where), where + ".from"),
                            point(required(segments[n], "to", where), where + ".to"),
                            number(required(segments[n], "speed_mm_s", where), where + ".speed_mm_s", 1e6)});
  }
  job.start = json.contains("start") ? point(json["start"], name + ": start") : job.segments.front().from;
  job.end = json.contains("end") ? point(json["end"], name + ": end") : job.segments.back().to;
  return job;
}

PrintJob from_csv(const std::string& text, const std::string& name) {
  using Quantity = CsvColumn::Quantity;
  std::istringstream in(text);
  SeparatedValues rows(in, name);
  SeparatedRow row;
  std::vector<CsvColumn> columns;
  PrintJob job;
  bool begun = false;
  const auto refuse = [&](const std::string& problem) { rows.fail(row.line, problem); };
  while (rows.next(row)) {
    if (row.blank()) continue;
    if (columns.empty()) {
      columns = csv_columns(row.fields, refuse);
      for (const CsvColumn& c : columns)
        if (c.quantity == Quantity::kZ || c.quantity == Quantity::kYaw)
          refuse("a job of lines has the columns x, y and speed, not " + shown_text(c.name));
      if (std::ranges::find(columns, Quantity::kSpeed, &CsvColumn::quantity) == columns.end())
        refuse("a job of lines has the columns x_mm, y_mm and speed_mm_s; there is none of the speed");
      continue;
    }
    if (row.fields.size() != columns.size())
      refuse(fmt::format("{} columns, the header has {}", row.fields.size(), columns.size()));
    Point2 p;
    double speed_mm_s = 0.0;
    for (std::size_t n = 0; n < columns.size(); ++n) {
      if (columns[n].quantity == Quantity::kIndex) continue;
      const double v = columns[n].scale * rows.finite_number(row, n, columns[n].name);
      if (!(std::abs(v) <= kMaxCoordinate_mm))
        refuse(fmt::format("{} must lie within +-{}", v, kMaxCoordinate_mm));
      (columns[n].quantity == Quantity::kX   ? p.x_mm
       : columns[n].quantity == Quantity::kY ? p.y_mm
                                             : speed_mm_s) = v;
    }
    if (std::exchange(begun, true))
      job.segments.push_back({job.end, p, speed_mm_s});
    else
      job.start = p;
    job.end = p;
  }
  if (job.segments.empty()) fail(name, "holds fewer than two points");
  return job;
}

}  // namespace

PrintJob read_print_job(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  if (extension != ".json" && extension != ".csv") fail(file.string(), "must end in .json or .csv");
  const std::string text = text_of(file);
  return extension == ".json" ? from_json(text, file.string()) : from_csv(text, file.string());
}

}  // namespace firn
