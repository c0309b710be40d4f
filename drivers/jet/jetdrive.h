// JetDriveDialect encodes and frames the commands of the MicroFab JetDrive III (CT-M3-02, 9600 8N1) that a
// print needs. Source: one lab's driver for a real unit (docs/devices/jet.md). Frame: 'S' (53h), length of
// the rest without the checksum, command, data (big-endian), sum of length .. last data mod 256.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/grid/figure.h"
#include "drivers/jet/jet_config.h"
#include "drivers/link/dialect.h"

namespace firn::drivers::jetdrive {

enum class Command : std::uint8_t {
  kReset = 0x01,
  kPoll = 0x02,
  kDrops = 0x03,
  kContinuous = 0x04,
  kPulse = 0x06,
  kStrobeDivider = 0x07,
  kSource = 0x08,
  kSoftTrigger = 0x09,
  kStrobeEnable = 0x10,
  kFullFrequency = 0x12,
  kStrobeDelay = 0x13,
  kGetVersion = 0xF0,
};

/// Voltages [V], whole volts; times [us] in steps of 0.1.
struct Waveform {
  int idle_v = 0, dwell_v = 0, echo_v = 0;
  double rise_us = 0.0, dwell_us = 0.0, fall_us = 0.0, echo_us = 0.0, final_us = 0.0;
  bool operator==(const Waveform&) const = default;
};

/// @pre whole volts
Waveform waveform_of(const JetConfig& config);
Waveform small_waveform_of(const JetConfig& config);

/// Why the waveform may not be sent, naming field, value and limit; empty = it may.
Violation waveform_refusal(const Waveform& waveform, const JetDialect& limits);

enum Format : std::uint8_t { kReply, kVersion, kPrompt, kEcho };

/// A frame with `data` after the command byte.
Request frame(Command command, std::span<const std::uint8_t> data, Repeat repeat);
/// Rise, fall and final time are raised to |dU| / (30 V/us) + 1 us, as the instrument's own program does.
Request pulse(const Waveform& waveform);

struct Reply {
  bool acknowledged = false;
  std::uint8_t status = 0;
  std::uint8_t version = 0;
};

class JetDriveDialect : public Dialect {
 public:
  JetDriveDialect();
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
  Reply parse(std::span<const std::byte> frame) const;

  JetDialect layout;
};

}  // namespace firn::drivers::jetdrive
