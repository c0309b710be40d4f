#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <ostream>

#include "cli/log_command.h"
#include "cli/message_types.h"
#include "core/options/number.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/record/log_statistics.h"
#include "files/record/record_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::int64_t kFirstWallTime_us = 1'000'000'000'000'000;  // 2001; smaller stamps are times of a run

struct LogInfo {
  std::uint64_t bytes = 0;
  bool numbered = true, has_index = false;
  std::uint64_t restarts = 0;
  record::DamageList damage;
  record::LogStatistics statistics;
};

/// The messages of a channel that begin with the same fingerprint, as a reader sees them.
struct TypeRow {
  std::uint64_t messages = 0;
  std::string fingerprint;         // hexadecimal; empty: none
  std::vector<std::string> names;  // more than one: types that share the fingerprint
  std::string not_lcm;
  std::string nearest;
  bool fits = false;
};

std::string hex_of(std::int64_t fingerprint) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(fingerprint));
  return text;
}

std::vector<TypeRow> info_rows(const std::string& channel, const record::ChannelStatistics& c,
                               const MessageTypes& types) {
  std::vector<TypeRow> info_rows;
  for (const auto& [fingerprint, count] : c.fingerprints) {
    TypeRow row;
    row.messages = count.messages;
    row.fingerprint = hex_of(fingerprint);
    for (const schema::Type* type : types.of(count.first)) row.names.push_back(full_name(*type));
    if (row.names.empty()) {
      row.not_lcm = not_lcm(channel, count.first).value_or("");
      const MessageTypes::Nearest near = types.nearest_to(channel, count.first);
      if (row.not_lcm.empty() && near.type) {
        row.nearest = full_name(*near.type);
        row.fits = near.fits;
      }
    }
    info_rows.push_back(std::move(row));
  }
  if (c.too_short > 0) {
    TypeRow row;
    row.messages = c.too_short;
    row.not_lcm = not_lcm(channel, c.first_short).value_or("");
    info_rows.push_back(std::move(row));
  }
  std::ranges::stable_sort(info_rows, std::greater{}, &TypeRow::messages);
  return info_rows;
}

std::string number_text(double v, const char* format = "%.6g") {
  char text[40];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

std::string seconds(std::int64_t us) { return number_text(double(us) * 1e-6, "%.6f"); }

std::string utc(std::int64_t us) {
  const std::time_t t = std::time_t(us / 1'000'000);
  std::tm parts{};
  char text[40];
  if (us < kFirstWallTime_us || !gmtime_r(&t, &parts) || parts.tm_year > 8000) return "";
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

using Json = nlohmann::ordered_json;

// The numbers of the text; of seconds all digits.
double rounded(double v) { return whole_number<double>(number_text(v)).value_or(v); }
double to_s(std::int64_t us) { return double(us) / 1e6; }

Json json_steps(const record::TimeSteps& s) {
  return {{"back", s.back},
          {"largest_s", to_s(s.largest_us)},
          {"event", s.largest_event},
          {"byte", s.largest_offset}};
}

Json json_row(const TypeRow& row) {
  Json json{{"messages", row.messages}};
  if (!row.fingerprint.empty()) json["fingerprint"] = row.fingerprint;
  json["types"] = row.names;
  if (!row.not_lcm.empty()) json["not_lcm"] = row.not_lcm;
  if (!row.nearest.empty()) json.update({{"nearest", row.nearest}, {"fits", row.fits}});
  return json;
}

Json json_channel(const std::string& name, const record::ChannelStatistics& c, const MessageTypes& types) {
  const record::Intervals::Gaps gaps = c.intervals.gaps();
  Json rows = Json::array();
  for (const TypeRow& row : info_rows(name, c, types)) rows.push_back(json_row(row));
  return {{"messages", c.messages},
          {"bytes", c.bytes},
          {"smallest", c.smallest},
          {"largest", c.largest},
          {"damaged", c.damaged},
          {"first_s", to_s(c.first_us)},
          {"last_s", to_s(c.last_us)},
          {"rate_hz", rounded(c.rate_hz())},
          {"median_interval_s", rounded(c.intervals.median_us() * 1e-6)},
          {"longest_interval_s", to_s(std::max<std::int64_t>(c.intervals.longest_us(), 0))},
          {"longest_begins_s", to_s(c.intervals.longest_begin_us())},
          {"gaps", gaps.count},
          {"gap_s", rounded(gaps.at_least_us * 1e-6)},
          {"time_order", json_steps(c.steps)},
          {"more_fingerprints", c.more_fingerprints},
          {"types", std::move(rows)}};
}

void print_info_json(const LogOptions& o, const LogInfo& info, const MessageTypes& types, std::ostream& out) {
  const record::LogStatistics& s = info.statistics;
  Json channels = Json::object();
  for (const auto& [name, channel] : s.channels()) channels[name] = json_channel(name, channel, types);
  const Json json{{"file", o.file},
                  {"bytes", info.bytes},
                  {"events", s.events()},
                  {"data_bytes", s.data_bytes()},
                  {"first_s", to_s(s.first_us())},
                  {"last_s", to_s(s.last_us())},
                  {"index", info.has_index},
                  {"numbered", info.numbered},
                  {"logs", info.restarts + 1},
                  {"damage_count", info.damage.count()},
                  {"lost", info.damage.lost()},
                  {"time_order", json_steps(s.steps())},
                  {"more_channels", s.more_channels()},
                  {"problems", types.problems()},
                  {"channels", std::move(channels)}};
  out << json.dump(-1, ' ', false, Json::error_handler_t::replace) << "\n";
}

void print_row(const TypeRow& row, std::ostream& out) {
  out << "    " << row.messages << " ";
  if (!row.not_lcm.empty()) {
    out << "not LCM: " << row.not_lcm << "\n";
    return;
  }
  for (std::size_t i = 0; i < row.names.size(); ++i) out << (i ? " or " : "") << row.names[i];
  if (row.names.empty()) out << "of unknown type";
  out << " (" << row.fingerprint << ")";
  if (row.names.size() > 1) out << ": these types have one fingerprint";
  if (!row.nearest.empty())
    out << "; the nearest by name is " << row.nearest
        << (row.fits ? ", whose members take as many bytes" : ", whose members do not fit");
  out << "\n";
}

void print_steps(const record::TimeSteps& steps, const char* indent, std::ostream& out) {
  if (steps.back > 0)
    out << indent << "time goes back " << steps.back << " times, by " << seconds(steps.largest_us)
        << " s at most (event " << steps.largest_event << ", byte " << steps.largest_offset << ")\n";
}

void print_channel(const std::string& name, const record::ChannelStatistics& c, const MessageTypes& types,
                   std::ostream& out) {
  out << "  " << name << ": " << c.messages << " messages, " << c.bytes << " bytes (" << c.smallest << " to "
      << c.largest << "), " << number_text(c.rate_hz(), "%.4g") << " Hz";
  if (c.intervals.count() > 0)
    out << ", longest interval " << seconds(c.intervals.longest_us()) << " s from "
        << seconds(c.intervals.longest_begin_us()) << " s";
  out << "\n";
  for (const TypeRow& row : info_rows(name, c, types)) print_row(row, out);
  if (c.more_fingerprints > 0) out << "    " << c.more_fingerprints << " with further fingerprints\n";
  const record::Intervals::Gaps gaps = c.intervals.gaps();
  if (gaps.count > 0)
    out << "    gaps: " << gaps.count << " intervals of " << number_text(gaps.at_least_us * 1e-6)
        << " s or more; the usual interval is " << number_text(c.intervals.usual_us() * 1e-6, "%.3g")
        << " s\n";
  print_steps(c.steps, "    ", out);
  if (c.damaged > 0) out << "    " << c.damaged << " damaged\n";
}

void print_info_text(const LogOptions& o, const LogInfo& info, const MessageTypes& types, std::ostream& out) {
  const record::LogStatistics& s = info.statistics;
  out << o.file << ": LCM log, " << info.bytes << " bytes, " << s.events() << " events on "
      << s.channels().size() << " channels, " << seconds(s.last_us() - s.first_us()) << " s";
  if (const std::string begin = utc(s.first_us()); !begin.empty()) out << " from " << begin;
  out << "\n";
  for (const std::string& problem : types.problems()) out << "  note: " << problem << "\n";
  if (!info.numbered) out << "  note: its event numbers do not count, as in logs of Java's LCM\n";
  if (info.restarts > 0) out << "  " << info.restarts + 1 << " logs, one behind the other\n";
  print_steps(s.steps(), "  ", out);
  for (std::size_t i = 0; i < std::min<std::size_t>(20, info.damage.list().size()); ++i) {
    const record::Damage& d = info.damage.list()[i];
    out << "  byte " << d.offset << ": " << d.reason << " (" << d.bytes << " bytes, " << d.lost << " lost)\n";
  }
  if (info.damage.count() > 20) out << "  ... " << info.damage.count() << " damages in all\n";
  for (const auto& [name, channel] : s.channels()) print_channel(name, channel, types, out);
  if (s.more_channels() > 0) out << "  " << s.more_channels() << " events on further channels\n";
}

}  // namespace

int log_info(const LogOptions& o, std::ostream& out) {
  const MessageTypes types(o.types);
  const record::EventLogFile file(o.file);
  if (record::RecordReader(file.bytes()).header_ok())
    throw UsageError(o.file + ": a record file, not an LCM log; `firn log verify` reads it");
  record::EventLogReader reader = file.reader();
  LogInfo info;
  info.bytes = file.bytes().size();
  info.has_index = file.has_index();
  while (const auto e = reader.next()) {
    info.statistics.add(*e);
    file.forget_before(e->offset);
  }
  if (info.statistics.events() == 0 && info.bytes > 0)
    throw UsageError(o.file + ": no LCM event in its " + std::to_string(info.bytes) + " bytes");
  info.numbered = reader.numbered();
  info.restarts = reader.restarts();
  info.damage = reader.damage();
  (o.json ? print_info_json : print_info_text)(o, info, types, out);
  return info.damage.count() ? kFailed : kOk;
}

}  // namespace firn
