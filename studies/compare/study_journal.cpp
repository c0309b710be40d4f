#include "studies/compare/study_journal.h"

#include <cmath>
#include <limits>
#include <optional>

#include "files/json.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

// Empty if the line is of a lab without these metrics.
std::optional<std::pair<std::string, StudyPrint>> parse_line(const std::string& line, const StudyLab& lab) {
  try {
    const Json j = Json::parse(line);
    StudyPrint p;
    p.finished = j.at("finished").get<bool>();
    p.outcome = j.at("outcome").get<std::string>();
    p.reason = j.at("reason").get<std::string>();
    p.cpu_s = j.at("cpu_s").get<double>();
    for (const report::StudyMetric& m : lab.metrics) {
      const Json& v = j.at("metrics").at(m.name);
      p.metrics.push_back(v.is_null() ? std::numeric_limits<double>::quiet_NaN() : v.get<double>());
    }
    if (const auto within = j.find("within_tolerance"); within != j.end()) p.within = within->get<bool>();
    if (const auto profile = j.find("profile"); profile != j.end())
      for (const Json& point : *profile)
        p.profile.push_back({point.at(0).get<double>(), point.at(1).get<double>()});
    return std::pair(j.at("digest").get<std::string>(), std::move(p));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

StudyJournal::StudyJournal(const std::filesystem::path& path, const StudyLab& lab)
    : lab_(lab),
      lines_(path, path.parent_path().string() + ": another firn compare is at work in this folder") {
  for (const std::string& line : lines_.read(damaged_)) {
    if (auto parsed = parse_line(line, lab_))
      prints_.insert_or_assign(std::move(parsed->first), std::move(parsed->second));
    else
      ++damaged_;
  }
}

const StudyPrint* StudyJournal::find(const std::string& digest) const {
  const auto it = prints_.find(digest);
  return it == prints_.end() ? nullptr : &it->second;
}

void StudyJournal::append(const std::string& digest, std::string_view arm, std::string_view part,
                          std::uint64_t seed, const StudyPrint& p) {
  Json metrics = Json::object();
  for (std::size_t m = 0; m < lab_.metrics.size(); ++m) {
    if (std::isfinite(p.metrics[m]))
      metrics[lab_.metrics[m].name] = p.metrics[m];
    else
      metrics[lab_.metrics[m].name] = nullptr;
  }
  Json record{{"digest", digest},   {"scheme", arm},          {"part", part},
              {"seed", seed},       {"finished", p.finished}, {"outcome", p.outcome},
              {"reason", p.reason}, {"cpu_s", p.cpu_s},       {"metrics", metrics}};
  if (p.within) record["within_tolerance"] = *p.within;
  for (const report::StudyProfilePoint& point : p.profile)
    if (std::isfinite(point.y)) record["profile"].push_back({point.x, point.y});
  const std::string json = record.dump(-1, ' ', true, Json::error_handler_t::replace);
  lines_.append(json);
  // The result is read back as a later call reads it.
  if (auto parsed = parse_line(json, lab_))
    prints_.insert_or_assign(std::move(parsed->first), std::move(parsed->second));
}

}  // namespace firn
