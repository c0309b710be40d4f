// FvpDialect encodes and frames FVP/1, the line protocol between Firn and a V+ program on the robot's
// controller (docs/devices/robot.md; no public protocol of the C40 exists). `@<seq> <VERB>
// <args>*<CRC4>\r\n`, at most 120 characters; the CRC is that of the text between `@` and `*`.
// Nothing here allocates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/link/checked_line.h"
#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::fvp {

inline constexpr int kMaxPoints = 8192;   ///< 131.072 s at 16 ms
inline constexpr int kPointsPerLine = 3;  ///< at most; fewer where 120 characters end
inline constexpr int kSlots = 2;          ///< paths that the controller holds
inline constexpr std::int64_t kMaxSeq = 65535;
inline constexpr std::int64_t kMaxId =
    9'999'999;  ///< path numbers stay exact in the controller's 32-bit reals

/// A request of number 0 is not answered and not remembered: path lines within a block.
inline constexpr std::int64_t kUnanswered = 0;
inline constexpr std::int64_t next_seq(std::int64_t seq) { return seq >= kMaxSeq ? 1 : seq + 1; }
/// The robot executes a newer request, repeats its last reply to an equal one and answers NAK 11 to one that
/// is older.
inline constexpr bool newer(std::int64_t seq, std::int64_t last) {
  const std::int64_t ahead = (seq - last + kMaxSeq) % kMaxSeq;
  return ahead > 0 && ahead <= kMaxSeq / 2;
}

enum class State : std::uint8_t { kBoot, kIdle, kLoading, kReady, kRunning, kHold, kFault, kEstop };
std::string_view name(State state);
std::optional<State> state_of(std::string_view name);

enum class Nak : std::int16_t {
  kBadCrc = 10,  ///< of a line, or the one of PATH END
  kBadSeq = 11,
  kWrongState = 20,
  kRange = 21,
  kJointLimit = 22,
  kNotCalibrated = 23,
  kNoPower = 24,
  kMonitorSpeed = 30,  ///< SPEED is not 100
  kMotion = 31,
  kWatchdog = 40,
};

/// Joints as the wire carries them: 1e-4 deg, 1e-4 deg, 1e-3 mm (up positive), 1e-4 deg.
using Counts = std::array<std::int32_t, 4>;
using Joints = std::array<double, 4>;  ///< rad, rad, mm, rad
inline constexpr std::int32_t kMaxCount = 9'999'999;
/// @pre finite, |result| <= kMaxCount
Counts counts_of(const Joints& joints);
Joints joints_of(const Counts& counts);

/// Answer to STAT.
struct Status {
  State state = State::kBoot;
  int state1 = 0;  ///< V+ STATE(1): 2 wait for power, 5 calibrating, 7 program control, 8 not calibrated …
  int state2 = 0;  ///< V+ STATE(2): 1 moving, 2 stopped as planned, 7, 8 stopped by an error …
  std::int32_t boot_count = 0;  ///< of the V+ program
  bool power = false;
  bool calibrated = false;
  int speed_percent = 100;   ///< monitor SPEED
  int error = 0;             ///< Nak or V+ error that led to FAULT, 0 = none
  std::int32_t running = 0;  ///< path under way, 0 = none
  int at = 0;                ///< points that it, or the last one, has passed
  std::int32_t last = 0;     ///< path that was started last and has ended, 0 = none since the boot
  bool last_done = false;    ///< it reached its end; false: it was stopped at point `at`
  std::int32_t last_ms = 0;  ///< from its motion's start to its end
  std::array<std::int32_t, kSlots> held{};  ///< paths that are complete and verified, 0 = slot free
  bool operator==(const Status&) const = default;
};
void put(LineWriter& line, const Status& status);
std::optional<Status> parse_status(WordReader& words);

void put(LineWriter& line, const Counts& counts);
std::optional<Counts> parse_counts(WordReader& words);

/// Begins a line: `@17 HELLO`, `!3 EVT`. Add words, then finish(1).
LineWriter request(std::int64_t seq, std::string_view verb);
LineWriter event(std::int64_t number, std::string_view kind);

/// Adds ` <first> j1 j2 j3 j4 …` to `@<seq> PATH P`: as many of `points`, at most three, as one line holds.
/// @returns how many it took; the line still lacks finish(1).
std::size_t put_points(LineWriter& line, std::size_t first, std::span<const Counts> points);
/// CRC of PATH END: of the numbers of all points in order with one space between any two, however the lines
/// were cut.
class PointsCrc {
 public:
  /// @param numbers of one line, as parse() and WordReader::rest() leave them: `j1 j2 j3 j4 j1 …`
  void add(std::string_view numbers);
  void add(const Counts& point);
  std::uint16_t value() const { return crc_; }

 private:
  std::uint16_t crc_ = 0xFFFF;
  bool first_ = true;
};

/// A whole line of either side, CRC and form checked.
struct Message {
  enum class Kind : std::uint8_t { kBad, kNumbered, kEvent };
  Kind kind = Kind::kBad;
  std::int64_t seq = 0;   ///< or the event's number
  std::string_view text;  ///< behind the number; of an event behind EVT
};
Message parse(std::string_view line);

enum Format : std::uint8_t { kLine, kBlock };

/// A request of one line; `finish` is done here. The number is kept in Request::argument.
Request to_request(LineWriter& line, std::int64_t seq, Repeat repeat, std::uint16_t tag);
/// Points [first, first + count) of FvpDialect::points as unanswered path lines and a last one that is
/// answered with the number of points that the robot then holds.
Request path_block(std::int64_t seq, std::size_t first, std::size_t count, std::uint16_t tag);

/// The host's side. Replies name their request, so a lost one is asked for again without draining the link.
class FvpDialect : public Dialect {
 public:
  FvpDialect();
  char line_end() const override { return '\n'; }
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
  void write(const Request& request, std::vector<std::byte>& tx) const override;

  std::span<const Counts> points;  ///< source of the path blocks, read when they are sent
};

LinkProbe link_probe();

}  // namespace firn::drivers::fvp
