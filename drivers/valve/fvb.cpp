#include "drivers/valve/fvb.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "core/options/enumerators.h"
#include "drivers/link/crc16.h"

namespace firn::drivers::fvb {
namespace {

static_assert(std::endian::native == std::endian::little, "lists go out as they lie in memory");

constexpr std::size_t kMaxReply = 15;
constexpr std::byte kMagic0{0xA5}, kMagic1{0x5A};

template <class T>
T read(std::span<const std::byte> from, std::size_t at) {
  T value;
  std::memcpy(&value, from.data() + at, sizeof value);
  return value;
}

/// A payload of a few fields.
class Fields {
 public:
  template <class T>
  Fields& add(T value) {
    std::memcpy(bytes_.data() + size_, &value, sizeof value);
    size_ += sizeof value;
    return *this;
  }
  std::span<const std::byte> bytes() const { return {bytes_.data(), size_}; }

 private:
  std::array<std::byte, 24> bytes_{};
  std::size_t size_ = 0;
};

Fields fields(const Begin& b) {
  return Fields().add(b.path).add(b.valve).add(b.entries).add(b.tick_us).add(b.pulse_us);
}

bool known(std::uint8_t type) { return (type >= 0x01 && type <= 0x09) || type == 0x7E || type == 0x7F; }

}  // namespace

std::string_view name(Type type) {
  switch (type) {
    case Type::kHello:
      return "HELLO";
    case Type::kBegin:
      return "BEGIN";
    case Type::kData:
      return "DATA";
    case Type::kEnd:
      return "END";
    case Type::kArm:
      return "ARM";
    case Type::kDisarm:
      return "DISARM";
    case Type::kStatus:
      return "STATUS";
    case Type::kAbort:
      return "ABORT";
    case Type::kSpit:
      return "SPIT";
    case Type::kAck:
      return "ACK";
    case Type::kNak:
      return "NAK";
  }
  return "unknown type";
}

std::string_view name(Refusal refusal) {
  switch (refusal) {
    case Refusal::kBadSeq:
      return "stale number";
    case Refusal::kWrongState:
      return "wrong state";
    case Refusal::kRange:
      return "out of range";
    case Refusal::kOrder:
      return "times not ascending or too close";
    case Refusal::kMismatch:
      return "the list differs from what was sent";
  }
  return "unknown reason";
}

std::string_view name(State state) {
  static constexpr std::array<std::string_view, 7> kNames{"idle",   "loading", "loaded", "armed",
                                                          "firing", "done",    "fault"};
  static_assert(kNames.size() == kTableSize<State>);
  return kNames[std::size_t(state)];
}

void encode(Type type, std::uint8_t seq, std::span<const std::byte> payload, std::vector<std::byte>& out) {
  if (payload.size() > kMaxPayload)
    throw std::length_error("a valve frame's payload is longer than 512 bytes");
  const std::size_t start = out.size();
  const auto n = std::uint16_t(payload.size());
  const std::array<std::byte, kHead> head{
      kMagic0, kMagic1, std::byte(type), std::byte(seq), std::byte(n & 255), std::byte(n >> 8)};
  out.insert(out.end(), head.begin(), head.end());
  out.insert(out.end(), payload.begin(), payload.end());
  const std::uint16_t crc = crc16(std::span(out).subspan(start + 2));
  out.push_back(std::byte(crc & 255));
  out.push_back(std::byte(crc >> 8));
}

void encode(std::uint8_t seq, const Begin& b, std::vector<std::byte>& out) {
  encode(Type::kBegin, seq, fields(b).bytes(), out);
}

void encode_data(std::uint8_t seq, std::uint16_t offset, std::span<const std::uint16_t> ticks,
                 std::vector<std::byte>& out) {
  std::array<std::byte, kMaxPayload> payload;
  const std::size_t n = std::min(ticks.size(), kEntriesPerFrame);
  std::memcpy(payload.data(), &offset, 2);
  if (n > 0) std::memcpy(payload.data() + 2, ticks.data(), 2 * n);
  encode(Type::kData, seq, std::span(payload).first(2 + 2 * n), out);
}

Found find(std::span<const std::byte> buffer) {
  Found f;
  std::size_t start = 0;
  while (start < buffer.size() &&
         (buffer[start] != kMagic0 || (start + 1 < buffer.size() && buffer[start + 1] != kMagic1)))
    ++start;
  if (start > 0) return {Found::Kind::kNoise, start, Type::kAck, 0, {}};
  if (buffer.size() < kHead) return f;
  const auto n = std::size_t(read<std::uint16_t>(buffer, 4));
  const auto type = std::uint8_t(buffer[2]);
  const Found noise{Found::Kind::kNoise, 1, Type::kAck, 0, {}};
  if (n > kMaxPayload || !known(type)) return noise;
  if (buffer.size() < kHead + n + kTail) return f;
  if (crc16(buffer.subspan(2, kHead - 2 + n)) != read<std::uint16_t>(buffer, kHead + n)) return noise;
  return {Found::Kind::kFrame, kHead + n + kTail, Type(type), std::uint8_t(buffer[3]),
          buffer.subspan(kHead, n)};
}

std::optional<Hello> parse_hello(std::span<const std::byte> p) {
  constexpr std::size_t kWithoutLimits = 5, kWithLimits = 12;
  if (p.size() != kWithoutLimits && p.size() != kWithLimits) return std::nullopt;
  Hello h{read<std::uint16_t>(p, 0), read<std::uint16_t>(p, 2), read<std::uint8_t>(p, 4)};
  if (p.size() == kWithoutLimits) return h;
  h.max_entries = read<std::uint16_t>(p, 5);
  h.step_us = read<std::uint16_t>(p, 7);
  h.max_pulse_us = read<std::uint16_t>(p, 9);
  h.max_duty_percent = read<std::uint8_t>(p, 11);
  const bool sound = h.max_entries >= 1 && h.max_entries <= kMaxEntries && h.max_pulse_us >= kMinPulse_us &&
                     h.max_duty_percent >= 1 && h.max_duty_percent <= 100;
  return sound ? std::optional(h) : std::nullopt;
}

std::optional<Status> parse_status(std::span<const std::byte> p) {
  if (p.size() != 15 || std::uint8_t(p[2]) > std::uint8_t(State::kFault)) return std::nullopt;
  Status s;
  s.boot_count = read<std::uint16_t>(p, 0);
  s.state = State(p[2]);
  s.path = read<std::uint32_t>(p, 3);
  s.next = read<std::uint16_t>(p, 7);
  s.since_us = read<std::uint32_t>(p, 9);
  s.late_us = read<std::uint16_t>(p, 13);
  return s.next <= kMaxEntries ? std::optional(s) : std::nullopt;
}

std::optional<Reply> parse_reply(const Found& f) {
  const std::size_t n = f.payload.size();
  const bool sized = (f.type == Type::kAck && n == 2) || (f.type == Type::kNak && n == 3) ||
                     (f.type == Type::kHello && parse_hello(f.payload).has_value()) ||
                     (f.type == Type::kStatus && parse_status(f.payload).has_value());
  if (!sized) return std::nullopt;
  return Reply{f.type, read<std::uint16_t>(f.payload, 0),
               f.type == Type::kNak ? std::uint8_t(f.payload[2]) : std::uint8_t(0)};
}

std::uint16_t list_crc(std::span<const std::uint16_t> ticks) { return crc16(std::as_bytes(ticks)); }

Request request(Type type, std::uint8_t seq, std::span<const std::byte> payload, Repeat repeat) {
  Request r;
  r.append(payload);
  r.format = kFrame;
  r.repeat = repeat;
  r.tag = std::uint16_t(type);
  r.argument = seq;
  return r;
}

Request begin(std::uint8_t seq, const Begin& b) {
  return request(Type::kBegin, seq, fields(b).bytes(), Repeat::kSetup);
}

Request spit(std::uint8_t seq, const Begin& pulses) {
  Request r = request(Type::kSpit, seq, fields(pulses).bytes(), Repeat::kNever);
  r.format = kPerson;
  return r;
}

Request number16(Type type, std::uint8_t seq, std::uint16_t value) {
  return request(type, seq, Fields().add(value).bytes(), Repeat::kSetup);
}

Request number32(Type type, std::uint8_t seq, std::uint32_t value, Repeat repeat) {
  return request(type, seq, Fields().add(value).bytes(), repeat);
}

Request data(std::uint8_t seq, std::size_t first, std::size_t count) {
  Request r = request(Type::kData, seq, Fields().add(std::uint32_t(first)).add(std::uint32_t(count)).bytes(),
                      Repeat::kSetup);
  r.format = kEntries;
  return r;
}

FvbDialect::FvbDialect() {
  numbered = true;
  timeouts.write_us = 100'000;  // a full frame takes 45 ms at 115200 baud
  timeouts.reply_us = 250'000;
  timeouts.read_us = 100'000;
}

Frame FvbDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const Found f = find(buffer);
  if (f.kind == Found::Kind::kIncomplete) {
    // No reply is long: a damaged length must not swallow the replies to come.
    const bool too_long = buffer.size() >= kHead && read<std::uint16_t>(buffer, 4) > kMaxReply;
    return too_long ? Frame{Frame::Kind::kCorrupt, 1} : Frame{};
  }
  if (f.kind == Found::Kind::kNoise || !parse_reply(f)) return {Frame::Kind::kCorrupt, f.size};
  const bool answers =
      f.type == Type::kNak || f.type == Type::kAck || (awaited && f.type == Type(awaited->tag));
  return {awaited && answers && f.seq == awaited->argument ? Frame::Kind::kReply : Frame::Kind::kIgnore,
          f.size};
}

Request FvbDialect::probe() const { return request(Type::kStatus, 1, {}, Repeat::kRead); }

void FvbDialect::write(const Request& r, std::vector<std::byte>& tx) const {
  const auto seq = std::uint8_t(r.argument);
  if (r.format == kPerson) return encode(Type::kSpit, seq, r.data(), tx);
  if (r.format != kEntries) return encode(Type(r.tag), seq, r.data(), tx);
  const std::size_t first = std::min<std::size_t>(read<std::uint32_t>(r.data(), 0), ticks.size());
  const std::size_t count = std::min<std::size_t>(read<std::uint32_t>(r.data(), 4), ticks.size() - first);
  encode_data(seq, std::uint16_t(first), ticks.subspan(first, count), tx);
}

LinkProbe link_probe() {
  std::vector<std::byte> hello;
  encode(Type::kHello, 1, {}, hello);
  return {"a valve with FVB/1", std::string(reinterpret_cast<const char*>(hello.data()), hello.size()),
          [](std::string_view s) {
            return find(std::as_bytes(std::span(s.data(), s.size()))).kind == Found::Kind::kFrame;
          }};
}

}  // namespace firn::drivers::fvb
