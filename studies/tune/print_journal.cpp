#include "studies/tune/print_journal.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>
#include <system_error>
#include <vector>

#include "files/digest.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "runtime/build_info.h"

namespace firn::tune {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const std::vector<double>& values) {
  Json j = Json::array();
  for (const double v : values)
    if (std::isfinite(v))
      j.push_back(v);
    else
      j.push_back(nullptr);
  return j;
}

std::vector<double> numbers_of(const Json& j) {
  std::vector<double> values;
  for (const Json& v : j)
    values.push_back(v.is_null() ? std::numeric_limits<double>::quiet_NaN() : v.get<double>());
  return values;
}

/// @throws UsageError naming the key
std::pair<std::string, LabPrint> parse_print(const std::string& where, const std::string& line) {
  const Json j = Json::parse(line, nullptr, false);
  const char* key = "digest";
  try {
    if (!j.is_object()) throw UsageError(where + "no simulated print");
    const auto at = [&](const char* name) -> const Json& { return j.at(key = name); };
    LabPrint p;
    std::string digest = at("digest").get<std::string>();
    p.finished = at("finished").get<bool>();
    p.reason = at("reason").get<std::string>();
    p.metrics = numbers_of(at("metrics"));
    p.features = numbers_of(at("features"));
    const std::vector<double> traits = numbers_of(at("traits"));
    if (traits.size() != 4) throw UsageError(where + "key 'traits': four numbers are wanted");
    p.traits = {traits[0], traits[1], traits[2], traits[3]};
    return {std::move(digest), std::move(p)};
  } catch (const Json::exception&) {
    throw UsageError(fmt::format("{}no simulated print: key '{}' is missing or of another type", where, key));
  }
}

/// True for the beginning of a line, as a writer that was killed leaves it.
bool cut_short(const std::string& line) {
  constexpr std::string_view kBegin = "0000000000000000 {";
  for (std::size_t n = 0; n < std::min(line.size(), kBegin.size()); ++n)
    if (kBegin[n] == '0' ? !std::isxdigit(static_cast<unsigned char>(line[n])) : line[n] != kBegin[n])
      return false;
  return line.back() != '}';
}

const std::filesystem::path& require_file(const std::filesystem::path& file) {
  std::error_code none;
  const auto status = std::filesystem::status(file, none);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw UsageError(file.string() + ": is no file");
  return file;
}

}  // namespace

PrintJournal::PrintJournal(const std::filesystem::path& file)
    : lines_(require_file(file), file.string() + ": another firn tune is at work with this file") {
  for (const LineJournal::Line& line : lines_.lines()) {
    const std::string where = fmt::format("{}: line {}: ", file.string(), line.number);
    if (line.right) {
      auto [digest, print] = parse_print(where, line.text);
      prints_.insert_or_assign(std::move(digest), std::move(print));
    } else if (cut_short(line.text)) {
      ++damaged_;
    } else {
      throw UsageError(where + "damaged, or no record of firn tune: its checksum is another");
    }
  }
  known_ = prints_.size();
}

std::string PrintJournal::digest_of(const Experiment& experiment, const Blobs& inputs, const LabDraw& draw,
                                    const LabPrintOptions& wanted) {
  std::string all = build_commit() + "\n" + dump(experiment) + std::string(draw.lab->name);
  for (const Blob& b : inputs) {
    all += "\n" + b.role + " " + b.sha256;
    // Inputs of a print that is planned have no digest yet.
    if (b.sha256.empty()) all += sha256_hex(b.bytes);
  }
  for (const double z : draw.z) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &z, sizeof bits);
    all += "\n" + std::to_string(bits);
  }
  all += "\n" + std::to_string(draw.seed) + (wanted.features ? " features" : "") +
         (wanted.noise == MapNoise::kFromMaps ? " noise from maps" : "");
  return sha256_hex(std::as_bytes(std::span(all)));
}

std::optional<LabPrint> PrintJournal::find(const std::string& digest) {
  const std::lock_guard hold(lock_);
  const auto it = prints_.find(digest);
  return it == prints_.end() ? std::nullopt : std::optional(it->second);
}

void PrintJournal::append(const std::string& digest, const LabPrint& p) {
  const Json j{
      {"digest", digest},
      {"finished", p.finished},
      {"reason", p.reason},
      {"metrics", numbers(p.metrics)},
      {"features", numbers(p.features)},
      {"traits", numbers({p.traits.saturated, p.traits.alternation, p.traits.swing, p.traits.overspill})}};
  const std::string line = j.dump(-1, ' ', true, Json::error_handler_t::replace);
  const std::lock_guard hold(lock_);
  lines_.append(line);
  prints_.insert_or_assign(digest, p);
}

}  // namespace firn::tune
