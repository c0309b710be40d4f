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
constexpr double kUsualLine = 1200.0, kChecksum = 18.0;   // [B], of a print with its metrics; beside a line
constexpr std::string_view kFirstKey = "{\"digest\":\"";  // of each line

struct Line {
  std::string digest;
  StudyOrigin origin;
  StudyPrint print;
};

// Empty if the line is of a lab without these metrics.
std::optional<Line> parse_line(const std::string& line, const std::vector<std::string>& values) {
  try {
    const Json j = Json::parse(line);
    StudyPrint p;
    p.finished = j.at("finished").get<bool>();
    p.outcome = j.at("outcome").get<std::string>();
    p.reason = j.at("reason").get<std::string>();
    p.cpu_s = j.at("cpu_s").get<double>();
    for (const std::string& name : values) {
      const Json& v = j.at("metrics").at(name);
      p.metrics.push_back(v.is_null() ? std::numeric_limits<double>::quiet_NaN() : v.get<double>());
    }
    if (const auto within = j.find("within_tolerance"); within != j.end()) p.within = within->get<bool>();
    if (const auto profile = j.find("profile"); profile != j.end())
      for (const Json& point : *profile)
        p.profile.push_back({point.at(0).get<double>(), point.at(1).get<double>()});
    if (const auto document = j.find("document"); document != j.end())
      p.document = document->get<std::string>();
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

StudyJournal::StudyJournal(const std::filesystem::path& path, std::span<const report::StudyMetric> values,
                           StudyPlatforms platforms, const StudyOrigin& origin)
    : StudyJournal(values, platforms, origin) {
  lines_.emplace(path, path.string() + ": another firn compare is at work on this journal");
  add(path, lines_->lines(), true);
}

StudyJournal::StudyJournal(std::span<const report::StudyMetric> values, StudyPlatforms platforms,
                           const StudyOrigin& origin)
    : platforms_(platforms), origin_(origin) {
  for (const report::StudyMetric& value : values) values_.push_back(value.name);
}

void StudyJournal::take_only(const std::vector<const StudyCell*>& cells) {
  only_.emplace();
  for (const StudyCell* c : cells) only_->insert(c->digest);
}

void StudyJournal::take(const std::filesystem::path& journal) {
  add(journal, LineJournal::read(journal), false);
}

// Newer lines of one journal stand for the older ones.
void StudyJournal::add(const std::filesystem::path& file, const std::vector<LineJournal::Line>& lines,
                       bool newer) {
  Damage damage{file};
  const auto damaged = [&](const LineJournal::Line& line) {
    if (damage.lines++ == 0) damage.first = line.number;
  };
  for (const LineJournal::Line& numbered : lines) {
    const std::string& line = numbered.text;
    if (!numbered.right) {
      damaged(numbered);
      continue;
    }
    if (only_ && line.starts_with(kFirstKey) &&
        !only_->contains(line.substr(kFirstKey.size(), kSha256Digits)))
      continue;
    auto parsed = parse_line(line, values_);
    if (!parsed) {
      damaged(numbered);
      continue;
    }
    bytes_ += line.size();
    ++lines_read_;
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
  if (damage.lines > 0) damage_.push_back(std::move(damage));
}

std::size_t StudyJournal::damaged() const {
  std::size_t all = 0;
  for (const Damage& d : damage_) all += d.lines;
  return all;
}

double StudyJournal::line_bytes() const {
  return lines_read_ == 0 ? kUsualLine : double(bytes_) / double(lines_read_) + kChecksum;
}

const StudyPrint* StudyJournal::find(const std::string& digest) const {
  const auto it = prints_.find(digest);
  return it == prints_.end() ? nullptr : &it->second;
}

void StudyJournal::append(const std::string& digest, std::string_view arm, std::string_view part,
                          std::uint64_t seed, const StudyPrint& p) {
  Json metrics = Json::object();
  for (std::size_t m = 0; m < values_.size(); ++m) {
    if (m < p.metrics.size() && std::isfinite(p.metrics[m]))
      metrics[values_[m]] = p.metrics[m];
    else
      metrics[values_[m]] = nullptr;
  }
  Json record{{"digest", digest},       {"build", origin_.build}, {"platform", origin_.platform},
              {"scheme", arm},          {"part", part},           {"seed", seed},
              {"finished", p.finished}, {"outcome", p.outcome},   {"reason", p.reason},
              {"cpu_s", p.cpu_s},       {"metrics", metrics}};
  if (p.within) record["within_tolerance"] = *p.within;
  for (const report::StudyProfilePoint& point : p.profile)
    if (std::isfinite(point.y)) record["profile"].push_back({point.x, point.y});
  if (!p.document.empty()) record["document"] = p.document;
  const std::string json = record.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (lines_) lines_->append(json);
  // The result is read back as a later call reads it.
  if (auto parsed = parse_line(json, values_))
    prints_.insert_or_assign(std::move(parsed->digest), std::move(parsed->print));
}

}  // namespace firn
