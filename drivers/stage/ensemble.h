// EnsembleDialect encodes and frames the ASCII commands of the Aerotech Ensemble (TCP 8000 or RS-232) that a
// print needs. Sources: EPICS motorAerotech, klauer/aerotech (docs/devices/stage.md). Lines end with "\n"
// both ways; a reply begins with `%` (done, maybe a value), `!` (not understood), `#` (fault) or `$` (the
// controller's own timeout). Replies carry neither a checksum nor the name of their request.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"
#include "drivers/stage/stage_config.h"

namespace firn::drivers::ensemble {

/// Texts and limits that differ between installations: a table, not code. `@` in a text is replaced by the
/// axis.
struct Table {
  char terminator = '\n';
  char ok = '%', nak = '!', fault = '#', timeout = '$';
  std::string pulse_count = "PSOCOUNT(@)";  ///< pulses since the last PSOCONTROL ARM [P]; empty: none
  std::string home = "HOME @";
  std::string home_program = "PROGRAM RUN 5, \"HomeAsync.bcx\"", stop_program = "PROGRAM STOP 5";
  int home_count_iglobal = 32, home_axis_iglobal = 33;  ///< read by the program: number of axes, the axis
  int first_iglobal = 50;                       ///< first of the IGLOBALs that hold the pulse increments
  int iglobals = 4096;                          ///< how many the controller has
  int array_limit = StageConfig{}.array_limit;  ///< pulses of one PSOARRAY
  int feedback_input = 0;                       ///< of PSOTRACK: 0 = primary encoder
  int increments() const {
    return iglobals - first_iglobal < array_limit ? iglobals - first_iglobal : array_limit;
  }
};

/// Bits of AXISSTATUS and AXISFAULT.
enum AxisStatus : std::uint32_t {
  kEnabled = 1u << 0,
  kHomed = 1u << 1,
  kInPosition = 1u << 2,
  kMoving = 1u << 3,
  kHoming = 1u << 14,
  kEstopInput = 1u << 31
};
inline constexpr std::uint32_t kFollowingError = 1u << 0 | 1u << 12;  ///< AXISFAULT: position, velocity
/// Numbers of the controller's parameters, read by GETPARM [S].
enum Parameter : std::int32_t {
  kCountsPerUnit = 2,
  kSoftwareLimitLow = 37,
  kSoftwareLimitHigh = 38,
  kGlobalIntegers = 124,
  kSoftwareLimitSetup = 210,
};
inline constexpr std::int64_t kTaskError = 6;  ///< TASKSTATE: 1 idle, 2 ready, 3 runs, 4 paused, 5 done [S]
/// The question for the state of the task that a program command names; empty: it names none.
std::string task_question(std::string_view program);
/// Names of the bits set in an AXISFAULT value, comma separated.
std::string fault_names(std::uint32_t bits);

enum Format : std::uint8_t { kAcknowledge, kValue, kText };

struct Reply {
  enum class Kind : std::uint8_t { kOk, kNak, kFault, kTimeout } kind = Kind::kOk;
  std::string_view value;  ///< after the first character
  std::optional<double> number() const;
  std::optional<std::uint32_t> bits() const;  ///< an integer, negative ones as two's complement
};

class EnsembleDialect : public Dialect {
 public:
  EnsembleDialect();
  char line_end() const override { return table.terminator; }
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
  Reply parse(std::span<const std::byte> frame) const;

  Table table;
};

/// Builds one command line.
class Line {
 public:
  Line(const Table& table, Repeat repeat, std::uint16_t tag, Format format = kAcknowledge);
  Line& text(std::string_view text);
  Line& axis(int axis);  ///< "@0"
  Line& integer(std::int64_t value);
  Line& fixed4(double value);  ///< mm, mm/s: rounded to 1e-4, no trailing zeros
  Line& fixed9(double value);  ///< s, mm, mm/s of a way: rounded to 1e-9, no trailing zeros
  Request done();
  operator Request() { return done(); }

 private:
  Line& fixed(double value, int decimals, double unit);
  const Table& table_;
  Request request_;
};

/// `text` of the table with '@' replaced by the axis.
Line& with_axis(Line& line, std::string_view text, int axis);

/// The question `verb` for one axis, which is the request's argument; its reply is a value.
Request question(const Table& table, std::string_view verb, int axis, std::uint16_t tag);

/// The setting `verb` of one axis, which is the request's argument, followed by `rest`.
Request setting(const Table& table, std::string_view verb, int axis, std::string_view rest,
                std::uint16_t tag);

LinkProbe link_probe();

}  // namespace firn::drivers::ensemble
