#include "studies/tune/print_journal.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "files/digest.h"
#include "runtime/build_info.h"

namespace firn::tuning {
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

std::optional<std::pair<std::string, LabPrint>> parse_print(const std::string& line) {
  try {
    const Json j = Json::parse(line);
    LabPrint p;
    p.finished = j.at("finished").get<bool>();
    p.reason = j.at("reason").get<std::string>();
    p.metrics = numbers_of(j.at("metrics"));
    p.features = numbers_of(j.at("features"));
    const std::vector<double> traits = numbers_of(j.at("traits"));
    if (traits.size() != 4) return std::nullopt;
    p.traits = {traits[0], traits[1], traits[2], traits[3]};
    return std::pair(j.at("digest").get<std::string>(), std::move(p));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

PrintJournal::PrintJournal(const std::filesystem::path& file)
    : lines_(file, file.string() + ": another firn tune is at work with this file") {
  for (const std::string& line : lines_.read(damaged_)) {
    if (auto print = parse_print(line))
      prints_.insert_or_assign(std::move(print->first), std::move(print->second));
    else
      ++damaged_;
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

}  // namespace firn::tuning
