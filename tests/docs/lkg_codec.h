// Keyence LK-G point laser, general mode: "M1\r" -> "M1,+01.2345\r" [LK-G manual LK-G-M-NO5-E, pp. 5-5, 5-6].
#pragma once

#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "drivers/link/dialect.h"

namespace firn::drivers::point_laser {

enum class Status { kOk, kNoValue, kAbove, kBelow, kRefused };

struct Reading {
  double height_mm = std::numeric_limits<double>::quiet_NaN();  ///< a number only where status is kOk
  Status status = Status::kNoValue;
  int error = 0;  ///< of "ER,<command>,<nn>"
};

/// Asks for the measured value of one head. Asking moves nothing, so it may be asked again.
inline Request measure(int head) {
  Request r;
  r.append(head == 1 ? std::string_view("M1\r") : std::string_view("M2\r"));
  r.repeat = Repeat::kRead;
  return r;
}

/// A reply without its CR. "XXXXXXXX" (no value) and "+FFFFFFF", "-FFFFFFF" (out of range) are never read as
/// numbers.
inline Reading parse(std::string_view reply) {
  Reading out;
  if (reply.starts_with("ER,")) {
    out.status = Status::kRefused;
    const std::string_view code = reply.substr(reply.rfind(',') + 1);
    std::from_chars(code.data(), code.data() + code.size(), out.error);
    return out;
  }
  std::string_view value = reply.substr(std::min<std::size_t>(reply.size(), 3));
  if (value.size() != 8 || value == "XXXXXXXX") return out;
  if (value.substr(1) == "FFFFFFF") {
    out.status = value[0] == '-' ? Status::kBelow : Status::kAbove;
    return out;
  }
  const bool negative = value[0] == '-';
  value.remove_prefix(1);
  double mm = 0.0;
  const auto [end, bad] = std::from_chars(value.data(), value.data() + value.size(), mm);
  if (bad != std::errc{} || end != value.data() + value.size() || !std::isfinite(mm)) return out;
  out.height_mm = negative ? -mm : mm;
  out.status = Status::kOk;
  return out;
}

/// Where a frame ends and whose it is: a line up to CR. "TG,…" comes by itself on timing events.
class LkgDialect final : public Dialect {
 public:
  LkgDialect() {
    timeouts.reply_us = 500'000;
    timeouts.quiet_us = 100'000;
  }

  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override {
    const std::string_view text(reinterpret_cast<const char*>(buffer.data()), buffer.size());
    const std::size_t end = text.find('\r');
    if (end == text.npos) {
      const bool endless = text.size() > kLongestLine;
      return {endless ? Frame::Kind::kCorrupt : Frame::Kind::kIncomplete, endless ? text.size() : 0};
    }
    const std::string_view line = text.substr(0, end);
    const bool timing = line.starts_with("TG,");
    const bool answers =
        awaited && (line.starts_with(awaited->text().substr(0, 2)) ||
                    (line.starts_with("ER,") && line.substr(3).starts_with(awaited->text().substr(0, 2))));
    return {timing    ? Frame::Kind::kUnsolicited
            : answers ? Frame::Kind::kReply
                      : Frame::Kind::kCorrupt,
            end + 1};
  }

  Request probe() const override {
    Request r;
    r.append(std::string_view("PR\r"));  // reads the program number
    return r;
  }

 private:
  static constexpr std::size_t kLongestLine = 256;
};

}  // namespace firn::drivers::point_laser
