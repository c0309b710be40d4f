#include "drivers/robot/fvp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/options/enumerators.h"
#include "drivers/link/crc16.h"

namespace firn::drivers::fvp {
namespace {

constexpr std::array<std::string_view, 8> kStates{"BOOT",    "IDLE", "LOADING", "READY",
                                                  "RUNNING", "HOLD", "FAULT",   "ESTOP"};
static_assert(kStates.size() == kTableSize<State>);
constexpr double kCountsPerRad = 1e4 * 180.0 / std::numbers::pi, kCountsPerMm = 1e3;
constexpr std::array<double, 4> kScale{kCountsPerRad, kCountsPerRad, kCountsPerMm, kCountsPerRad};

struct Block {
  std::uint32_t first = 0, count = 0;
};

void append(std::vector<std::byte>& tx, std::string_view line) {
  const auto bytes = std::as_bytes(std::span(line.data(), line.size()));
  tx.insert(tx.end(), bytes.begin(), bytes.end());
}

}  // namespace

std::string_view name(State state) { return kStates[std::size_t(state)]; }

std::optional<State> state_of(std::string_view name) {
  for (std::size_t n = 0; n < kStates.size(); ++n)
    if (kStates[n] == name) return State(n);
  return std::nullopt;
}

Counts counts_of(const Joints& joints) {
  Counts counts;
  for (std::size_t j = 0; j < 4; ++j) counts[j] = std::int32_t(std::llround(joints[j] * kScale[j]));
  return counts;
}

Joints joints_of(const Counts& counts) {
  Joints joints;
  for (std::size_t j = 0; j < 4; ++j) joints[j] = counts[j] / kScale[j];
  return joints;
}

void put(LineWriter& line, const Counts& counts) {
  for (const std::int32_t c : counts) line.word(c);
}

std::optional<Counts> parse_counts(WordReader& words) {
  Counts counts;
  for (std::int32_t& c : counts) c = std::int32_t(words.number(-kMaxCount, kMaxCount));
  return words.good() ? std::optional(counts) : std::nullopt;
}

void put(LineWriter& line, const Status& s) {
  line.word(name(s.state)).word(s.state1).word(s.state2).word(s.boot_count).word(s.power).word(s.calibrated);
  line.word(s.speed_percent).word(s.error).word(s.running).word(s.at);
  line.word(s.last).word(s.last_done).word(s.last_ms);
  for (const std::int32_t id : s.held) line.word(id);
}

std::optional<Status> parse_status(WordReader& words) {
  Status s;
  const std::optional<State> state = state_of(words.word());
  if (!state) return std::nullopt;
  s.state = *state;
  s.state1 = int(words.number(0, 99));
  s.state2 = int(words.number(0, 99));
  s.boot_count = std::int32_t(words.number(0, 99'999));
  s.power = words.number(0, 1) != 0;
  s.calibrated = words.number(0, 1) != 0;
  s.speed_percent = int(words.number(0, 999));
  s.error = int(words.number(-9999, 9999));
  s.running = std::int32_t(words.number(0, kMaxId));
  s.at = int(words.number(0, kMaxPoints));
  s.last = std::int32_t(words.number(0, kMaxId));
  s.last_done = words.number(0, 1) != 0;
  s.last_ms = std::int32_t(words.number(0, 9'999'999));
  for (std::int32_t& id : s.held) id = std::int32_t(words.number(0, kMaxId));
  return words.good() && words.at_end() ? std::optional(s) : std::nullopt;
}

LineWriter request(std::int64_t seq, std::string_view verb) {
  LineWriter line;
  line.text("@").number(seq).word(verb);
  return line;
}

LineWriter event(std::int64_t number, std::string_view kind) {
  LineWriter line;
  line.text("!").number(number).text(" EVT").word(kind);
  return line;
}

std::size_t put_points(LineWriter& line, std::size_t first, std::span<const Counts> points) {
  line.word(std::int64_t(first));
  std::size_t n = 0;
  for (; n < points.size() && n < std::size_t(kPointsPerLine); ++n) {
    LineWriter longer = line;
    put(longer, points[n]);
    if (longer.overflow()) break;
    line = longer;
  }
  return n;
}

void PointsCrc::add(std::string_view numbers) {
  if (!first_) crc_ = crc16(" ", crc_);
  first_ = false;
  crc_ = crc16(numbers, crc_);
}

void PointsCrc::add(const Counts& point) {
  LineWriter line;
  put(line, point);
  add(line.so_far().substr(1));
}

Message parse(std::string_view line) {
  Message m;
  if (line.size() > LineWriter::kLongest || line.empty() || (line[0] != '@' && line[0] != '!')) return m;
  const std::optional<std::string_view> text = checked_text(line, 1);
  if (!text) return m;
  WordReader words(*text);
  m.seq = words.number(0, kMaxSeq);
  if (!words.good() || text->front() == ' ') return m;
  if (line[0] == '!' && words.word() != "EVT") return m;
  m.text = words.rest();
  if (m.text.size() < 2 || m.text[0] != ' ' || m.text[1] == ' ') return m;
  m.text.remove_prefix(1);
  m.kind = line[0] == '!' ? Message::Kind::kEvent : Message::Kind::kNumbered;
  return m;
}

Request to_request(LineWriter& line, std::int64_t seq, Repeat repeat, std::uint16_t tag) {
  Request r;
  r.append(line.finish(1));
  r.format = kLine;
  r.repeat = repeat;
  r.tag = tag;
  r.argument = std::int32_t(seq);
  return r;
}

Request path_block(std::int64_t seq, std::size_t first, std::size_t count, std::uint16_t tag) {
  Request r;
  const Block block{std::uint32_t(first), std::uint32_t(count)};
  r.append(std::as_bytes(std::span(&block, 1)));
  r.format = kBlock;
  r.repeat = Repeat::kSetup;
  r.tag = tag;
  r.argument = std::int32_t(seq);
  return r;
}

FvpDialect::FvpDialect() {
  numbered = true;
  timeouts.write_us = 0;
  timeouts.reply_us = 250'000;
  timeouts.read_us = 100'000;
}

Frame FvpDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view all = text_of(buffer);
  const std::size_t end = all.find('\n');
  if (end == std::string_view::npos)
    return all.size() > LineWriter::kLongest ? Frame{Frame::Kind::kCorrupt, all.size()} : Frame{};
  const std::size_t size = end + 1;
  const Message m = parse(all.substr(0, size));
  switch (m.kind) {
    case Message::Kind::kBad:
      return {Frame::Kind::kCorrupt, size};
    case Message::Kind::kEvent:
      return {Frame::Kind::kUnsolicited, size};
    case Message::Kind::kNumbered:
      break;
  }
  const bool reply = m.text.starts_with("ACK") || m.text.starts_with("NAK ");
  if (!reply) return {Frame::Kind::kCorrupt, size};
  return {awaited && m.seq == awaited->argument ? Frame::Kind::kReply : Frame::Kind::kIgnore, size};
}

Request FvpDialect::probe() const {
  LineWriter line = request(1, "STAT");
  return to_request(line, 1, Repeat::kRead, 0);
}

void FvpDialect::write(const Request& r, std::vector<std::byte>& tx) const {
  if (r.format != kBlock) return Dialect::write(r, tx);
  Block block;
  std::memcpy(&block, r.bytes.data(), sizeof block);
  std::size_t at = std::min<std::size_t>(block.first, points.size());
  const std::size_t end = std::min<std::size_t>(at + block.count, points.size());
  while (at < end) {
    const std::span<const Counts> left = points.subspan(at, end - at);
    LineWriter line = request(kUnanswered, "PATH P");
    std::size_t n = put_points(line, at, left);
    if (at + n == end) {  // the last line of the block carries the number, which may cost it a point
      line = request(r.argument, "PATH P");
      n = put_points(line, at, left);
      if (at + n < end) {
        line = request(kUnanswered, "PATH P");
        n = put_points(line, at, left.first(n));
      }
    }
    append(tx, line.finish(1));
    at += n;
  }
}

LinkProbe link_probe() {
  LineWriter line;
  line.text("@").number(1).word("HELLO FIRN 1");
  return {"a robot with FVP/1", std::string(line.finish(1)),
          [](std::string_view s) {
            const std::size_t end = s.find('\n');
            return end != s.npos && parse(s.substr(0, end + 1)).kind != Message::Kind::kBad;
          },
          '\n'};
}

}  // namespace firn::drivers::fvp
