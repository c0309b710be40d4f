#include "drivers/stage/grbl.h"

#include <algorithm>
#include <cstdio>

#include "core/options/number.h"

namespace firn::drivers::grbl {
namespace {

constexpr std::size_t kLongest = 512;  // [OPT:…] and reports with all fields stay far below

struct Meaning {
  int number;
  std::string_view text;
};
// doc/csv/error_codes_en_US.csv and alarm_codes_en_US.csv of gnea/grbl [C]; of the errors those that a driver
// can meet.
constexpr Meaning kErrors[] = {{1, "a letter is missing"},
                               {2, "a number is damaged"},
                               {3, "it has no such command"},
                               {5, "homing is not enabled ($22)"},
                               {8, "it must be idle for that"},
                               {9, "locked by an alarm"},
                               {10, "soft limits need homing"},
                               {11, "the line is too long"},
                               {15, "the target is beyond its travel"},
                               {20, "it does not know the command"},
                               {22, "no feed rate"},
                               {33, "the target cannot be reached"}};
constexpr Meaning kAlarms[] = {{1, "hard limit: the place is lost"},
                               {2, "the target is beyond its travel"},
                               {3, "reset while it moved: the place is lost"},
                               {4, "probe: wrong state at the beginning"},
                               {5, "probe: no contact"},
                               {6, "homing was reset"},
                               {7, "homing: the door was opened"},
                               {8, "homing: the switch did not clear"},
                               {9, "homing: no switch was found"}};

std::optional<std::array<double, 3>> three_of(std::string_view text) {
  std::array<double, 3> values{};
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t comma = text.find(',');
    // A board with more axes sends more numbers.
    const std::optional<double> value = whole_number<double>(text.substr(0, comma));
    if (!value || (a < 2 && comma == text.npos)) return std::nullopt;
    values[a] = *value;
    text.remove_prefix(comma == text.npos ? text.size() : comma + 1);
  }
  return values;
}

std::optional<State> state_of(std::string_view word) {
  if (word == "Idle") return State::kIdle;
  if (word == "Run") return State::kRun;
  if (word == "Hold:0") return State::kHoldComplete;
  if (word.starts_with("Hold")) return State::kHolding;
  if (word == "Jog") return State::kJog;
  if (word == "Alarm" || word.starts_with("Alarm:")) return State::kAlarm;
  if (word.starts_with("Door")) return State::kDoor;
  if (word == "Check") return State::kCheck;
  if (word == "Home") return State::kHome;
  if (word == "Sleep") return State::kSleep;
  return std::nullopt;
}

}  // namespace

std::optional<Report> parse_report(std::string_view line) {
  if (!line.starts_with('<') || !line.ends_with('>')) return std::nullopt;
  line = line.substr(1, line.size() - 2);
  Report r;
  bool placed = false;
  for (bool first = true; !line.empty(); first = false) {
    const std::size_t bar = std::min(line.find('|'), line.size());
    const std::string_view field = line.substr(0, bar);
    line.remove_prefix(std::min(bar + 1, line.size()));
    if (first) {
      const std::optional<State> state = state_of(field);
      if (!state) return std::nullopt;
      r.state = *state;
      continue;
    }
    const bool machine = field.starts_with("MPos:"), work = field.starts_with("WPos:");
    if (!machine && !work && !field.starts_with("WCO:")) continue;
    const auto values = three_of(field.substr(field.find(':') + 1));
    if (!values) return std::nullopt;
    if (machine || work) {
      r.place_mm = *values;
      r.of_machine = machine;
      placed = true;
    } else {
      r.offset_mm = *values;
    }
  }
  return placed ? std::optional(r) : std::nullopt;
}

std::optional<std::pair<int, double>> parse_setting(std::string_view line) {
  const std::size_t equals = line.find('=');
  if (!line.starts_with('$') || equals == line.npos) return std::nullopt;
  const auto number = whole_number<int>(line.substr(1, equals - 1), 0, 999);
  const auto value = whole_number<double>(line.substr(equals + 1));
  if (!number || !value) return std::nullopt;
  return std::pair(*number, *value);
}

std::string meaning_of(std::string_view line) {
  const bool alarm = line.starts_with("ALARM:");
  const std::string_view digits = line.substr(std::min(line.find(':') + 1, line.size()));
  const auto number = whole_number<int>(digits, 0, 999);
  std::string text = std::string(alarm ? "alarm " : "error ") + std::string(digits);
  const std::span<const Meaning> all =
      alarm ? std::span<const Meaning>(kAlarms) : std::span<const Meaning>(kErrors);
  const auto row = number ? std::ranges::find(all, *number, &Meaning::number) : all.end();
  return row == all.end() ? text : text + ": " + std::string(row->text);
}

GrblDialect::GrblDialect() {
  timeouts.reply_us = 1'000'000;
  timeouts.read_us = 200'000;
  timeouts.quiet_us = 150'000;
}

Frame GrblDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view all = text_of(buffer);
  const std::size_t end = all.find('\n');
  if (end == all.npos) return all.size() > kLongest ? Frame{Frame::Kind::kCorrupt, all.size()} : Frame{};
  const std::size_t size = end + 1;
  const std::string_view text = all.substr(0, end);
  const auto reply_if = [&](Format format, Frame::Kind otherwise) {
    return Frame{awaited && awaited->format == format ? Frame::Kind::kReply : otherwise, size};
  };
  if (text == "ok") return reply_if(kOk, awaited ? Frame::Kind::kCorrupt : Frame::Kind::kIgnore);
  if (text.starts_with("error:"))
    return reply_if(kOk, awaited ? Frame::Kind::kCorrupt : Frame::Kind::kUnsolicited);
  if (text.starts_with("Grbl ")) return reply_if(kWelcome, Frame::Kind::kUnsolicited);
  if (text.starts_with('<')) {
    if (!parse_report(text)) return {Frame::Kind::kCorrupt, size};
    return reply_if(kReport, Frame::Kind::kUnsolicited);
  }
  if (text.empty()) return {Frame::Kind::kIgnore, size};
  const bool pushed = text.starts_with("ALARM:") || text.starts_with('[') || text.starts_with('>') ||
                      parse_setting(text).has_value() || text.starts_with("$N");
  return {pushed ? Frame::Kind::kUnsolicited : Frame::Kind::kCorrupt, size};
}

Request GrblDialect::probe() const { return status(0); }

Request line(std::string_view text, std::uint16_t tag, Repeat repeat, std::int64_t reply_us) {
  Request r;
  r.append(text);
  r.append("\n");
  r.format = kOk;
  r.tag = tag;
  r.repeat = repeat;
  r.reply_us = reply_us;
  return r;
}

Request status(std::uint16_t tag) {
  Request r;
  r.append(std::string_view(&kStatus, 1));
  r.format = kReport;
  r.tag = tag;
  r.repeat = Repeat::kRead;
  return r;
}

Request reset(std::uint16_t tag) {
  Request r;
  r.append(std::string_view(&kReset, 1));
  r.format = kWelcome;
  r.tag = tag;
  r.repeat = Repeat::kSetup;
  r.reply_us = 2'000'000;  // a board that has just had its power waits for its boot loader
  return r;
}

std::string_view text_of_line(std::span<const std::byte> frame) {
  const std::string_view text = text_of(frame);
  return text.substr(0, text.find('\n'));
}

std::string fixed(const char* format, double value) {
  char text[120];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

LinkProbe link_probe() {
  return {"a GRBL board", std::string(1, kStatus),
          [](std::string_view heard) {
            const std::size_t end = heard.find('\n');
            return end != heard.npos && parse_report(heard.substr(0, end)).has_value();
          },
          '\n'};
}

}  // namespace firn::drivers::grbl
