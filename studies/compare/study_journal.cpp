#include "studies/compare/study_journal.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "files/digest.h"
#include "files/json.h"
#include "runtime/build_info.h"
#include "runtime/result_fingerprint.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kOriginDigits = 16, kSha256Digits = 64;
constexpr std::string_view kFirstKey = "{\"digest\":\"";  // of each line

struct Line {
  std::string digest;
  StudyOrigin origin;
  StudyPrint print;
};

// Empty if the line is of a lab without these metrics.
std::optional<Line> parse_line(const std::string& line, const StudyLab& lab) {
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
    return Line{
        j.at("digest").get<std::string>(), {j.value("build", ""), j.value("platform", "")}, std::move(p)};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

StudyOrigin study_origin() {
  const std::string build = build_sources() + "\n" + __VERSION__;
  return {sha256_hex(std::as_bytes(std::span(build))).substr(0, kOriginDigits),
          fmt::format("{:016x}", digest_of(result_fingerprint()))};
}

StudyJournal::StudyJournal(const std::filesystem::path& path, const StudyLab& lab, StudyPlatforms platforms,
                           const StudyOrigin& origin)
    : StudyJournal(lab, platforms, origin) {
  lines_.emplace(path, path.string() + ": another firn compare is at work on this journal");
  add(lines_->read(damaged_), true);
}

StudyJournal::StudyJournal(const StudyLab& lab, StudyPlatforms platforms, const StudyOrigin& origin)
    : lab_(lab), platforms_(platforms), origin_(origin) {}

void StudyJournal::take_only(const std::vector<const StudyCell*>& cells) {
  only_.emplace();
  for (const StudyCell* c : cells) only_->insert(c->digest);
}

void StudyJournal::take(const std::filesystem::path& journal) {
  add(LineJournal::read(journal, damaged_), false);
}

// Newer lines of one journal stand for the older ones.
void StudyJournal::add(const std::vector<std::string>& lines, bool newer) {
  for (const std::string& line : lines) {
    if (only_ && line.starts_with(kFirstKey) &&
        !only_->contains(line.substr(kFirstKey.size(), kSha256Digits)))
      continue;
    auto parsed = parse_line(line, lab_);
    if (!parsed) {
      ++damaged_;
      continue;
    }
    const bool same_build = parsed->origin.build == origin_.build,
               same_platform = parsed->origin.platform == origin_.platform;
    of_other_builds_ += !same_build;
    of_other_platforms_ += same_build && !same_platform;
    if (!same_build || (!same_platform && platforms_ == StudyPlatforms::kThis)) continue;
    if (newer && same_platform)
      prints_.insert_or_assign(std::move(parsed->digest), std::move(parsed->print));
    else
      prints_.try_emplace(std::move(parsed->digest), std::move(parsed->print));
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
  Json record{{"digest", digest},       {"build", origin_.build}, {"platform", origin_.platform},
              {"scheme", arm},          {"part", part},           {"seed", seed},
              {"finished", p.finished}, {"outcome", p.outcome},   {"reason", p.reason},
              {"cpu_s", p.cpu_s},       {"metrics", metrics}};
  if (p.within) record["within_tolerance"] = *p.within;
  for (const report::StudyProfilePoint& point : p.profile)
    if (std::isfinite(point.y)) record["profile"].push_back({point.x, point.y});
  const std::string json = record.dump(-1, ' ', true, Json::error_handler_t::replace);
  lines_->append(json);
  // The result is read back as a later call reads it.
  if (auto parsed = parse_line(json, lab_))
    prints_.insert_or_assign(std::move(parsed->digest), std::move(parsed->print));
}

}  // namespace firn
