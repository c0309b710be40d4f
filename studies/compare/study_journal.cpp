#include "studies/compare/study_journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "files/record/checksum.h"
#include "files/usage_error.h"
#include "print/folder/run_folder.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

std::string checksum_of(std::string_view text) {
  char hex[17];
  std::snprintf(hex, sizeof hex, "%016llx",
                static_cast<unsigned long long>(logfile::checksum64(std::as_bytes(std::span(text)))));
  return hex;
}

// "<checksum of the rest> <JSON>"; empty if the line has another form, or is of a lab without these metrics.
std::optional<std::pair<std::string, StudyPrint>> parse_line(std::string_view line, const StudyLab& lab) {
  if (line.size() < 18 || line[16] != ' ' || checksum_of(line.substr(17)) != line.substr(0, 16))
    return std::nullopt;
  try {
    const Json j = Json::parse(line.substr(17));
    StudyPrint p;
    p.finished = j.at("finished").get<bool>();
    p.outcome = j.at("outcome").get<std::string>();
    p.reason = j.at("reason").get<std::string>();
    p.cpu_s = j.at("cpu_s").get<double>();
    for (const replay::StudyMetric& m : lab.metrics) {
      const Json& v = j.at("metrics").at(m.name);
      p.metrics.push_back(v.is_null() ? std::numeric_limits<double>::quiet_NaN() : v.get<double>());
    }
    if (const auto profile = j.find("profile"); profile != j.end())
      for (const Json& point : *profile)
        p.profile.push_back({point.at(0).get<double>(), point.at(1).get<double>()});
    return std::pair(j.at("digest").get<std::string>(), std::move(p));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

StudyJournal::StudyJournal(const std::filesystem::path& path, const StudyLab& lab) : path_(path), lab_(lab) {
  fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd_ < 0) throw UsageError(path.string() + ": cannot be opened: " + std::strerror(errno));
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    ::close(fd_);
    throw UsageError(path.parent_path().string() + ": another firn compare is at work in this folder");
  }
  read_all();
}

StudyJournal::~StudyJournal() { ::close(fd_); }

void StudyJournal::read_all() {
  const std::string text = read_file(path_);
  torn_ = !text.empty() && text.back() != '\n';
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = std::string_view(text).substr(at, end - at);
    at = end + 1;
    if (line.empty()) continue;
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
  for (const replay::StudyProfilePoint& point : p.profile)
    if (std::isfinite(point.y)) record["profile"].push_back({point.x, point.y});
  const std::string json = record.dump(-1, ' ', true, Json::error_handler_t::replace);
  const std::string line = (torn_ ? "\n" : "") + checksum_of(json) + " " + json + "\n";
  torn_ = false;
  std::size_t done = 0;
  while (done < line.size()) {
    const ssize_t n = ::write(fd_, line.data() + done, line.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw std::runtime_error(path_.string() + ": cannot be written: " + std::strerror(errno));
    done += std::size_t(n);
  }
  // The result is read back as a later call reads it.
  if (auto parsed = parse_line(
          std::string_view(line).substr(line[0] == '\n' ? 1 : 0, line.size() - 1 - (line[0] == '\n')), lab_))
    prints_.insert_or_assign(std::move(parsed->first), std::move(parsed->second));
}

}  // namespace firn
