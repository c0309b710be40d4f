// WorldRecord writes the world's own record: true events in order of time. `firn audit` and the kill tests
// read it. File: DIR/world.rec in the framing of files/record/record_file.h; the record's kind is RecordKind,
// its payload the little-endian struct below of that name, packed as declared (no padding).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/grid/grid.h"
#include "plant/record/ports.h"

namespace firn::plant {

enum class RecordKind : std::uint16_t {
  kBegin = 1,        ///< BeginRecord: a world begins or goes on
  kShot = 2,         ///< ShotRecord: a trigger pulse reached the jet
  kScanTrigger = 3,  ///< ScanRecord: a trigger pulse reached the profiler
  kLamp = 4,         ///< LampRecord
  kLink = 5,         ///< LinkRecord: a port was connected or disconnected
  kDevice = 6,       ///< DeviceRecord: an instrument changed state, or was abused
  kShots = 7,        ///< ShotRecord[]: several in a row, in order
  kTruth = 9,        ///< TruthRecord: the world was asked for its true surface
  kFiring = 8,       ///< FiringRecord: a valve has fired a list, to its end or not
};

/// The outcome of a trigger.
enum class ShotOutcome : std::uint8_t {
  kFired = 0,
  kMissed = 1,           ///< the jet obeyed, no droplet came
  kGatedSource = 2,      ///< the jet was not set to external triggers
  kGatedNoWaveform = 3,  ///< no PULSE was loaded since power on
  kGatedBusy = 4,        ///< the jet was resetting or loading a waveform
  kGatedTooFast = 5,     ///< sooner after the last droplet than the jet can follow
};

struct BeginRecord {
  std::int64_t t_us = 0;
  std::int64_t droplets_before = 0;  ///< fired before this moment, by the restored state
  std::uint32_t exposures = 0;
  std::uint32_t restored = 0;  ///< 1: went on from a saved state
};
struct ShotRecord {
  std::int64_t t_us = 0;
  double x_mm = 0.0,
         y_mm = 0.0;  ///< stage; the nozzle of ink B is elsewhere (WorldConfig::nozzle_b_x_mm)
  double landed_x_mm = 0.0, landed_y_mm = 0.0;
  double volume_mm3 = 0.0;      ///< 0 unless fired
  std::int32_t i = 0, j = 0;    ///< cell nearest to the nozzle, may be off the grid
  std::uint32_t exposures = 0;  ///< cures before
  ShotOutcome outcome = ShotOutcome::kFired;
  std::uint8_t nozzle = 0;  ///< 0: jet, ink A; 1: jet_b, ink B
  std::uint8_t reserved[2] = {};
};
struct ScanRecord {
  std::int64_t t_us = 0;
  double y_mm = 0.0;  ///< place of the line on the part
  std::uint32_t trigger_count = 0;
  std::int32_t encoder_count = 0;
};
enum class LampEvent : std::uint8_t {
  kOpened = 1,
  kClosed = 2,    ///< by command or at the end of a timed exposure
  kWatchdog = 3,  ///< closed by the lamp's own longest on-time
};
struct LampRecord {
  std::int64_t t_us = 0;
  double dose_s = 0.0;          ///< iris share x open time; 0 when opened
  std::uint32_t exposures = 0;  ///< after the event
  LampEvent event = LampEvent::kOpened;
  std::uint8_t cured = 0;  ///< 1: the dose sufficed
  std::uint8_t reserved[2] = {};
};
struct LinkRecord {
  std::int64_t t_us = 0;
  Port port = Port::kStage;
  std::uint8_t connected = 0;
  std::uint8_t by_instrument = 0;  ///< 1: the instrument closed it
  std::uint8_t reserved[5] = {};
};
enum class DeviceEvent : std::uint8_t {
  kJetArmed = 1,     ///< SOURCE external
  kJetDisarmed = 2,  ///< value = triggers obeyed since it was armed
  kJetAbused = 3,    ///< PULSE while droplets were being fired; value = microseconds since the last droplet
  kStageMoving = 4,
  kStageStopped = 5,
  kStageAborted = 6,    ///< by command
  kStageWatchdog = 7,   ///< link lost while moving: decelerated, PSO off
  kStageFault = 8,      ///< value = axis fault bits
  kPsoArmed = 9,        ///< value = axis
  kPsoOff = 10,         ///< value = axis
  kRebooted = 11,       ///< value = boot count
  kRobotMotion = 12,    ///< a motion begins; value = path, 0 = another move
  kRobotRest = 13,      ///< it ended as planned; value = path
  kRobotBraked = 14,    ///< it was stopped; value = path
  kRobotWatchdog = 15,  ///< no sign of life while a path ran
  kRobotError = 16,     ///< value = error
  kSignals = 17,        ///< value = mask in force
  kValveArmed = 18,     ///< value = path
  kScraped = 19,        ///< a nozzle went through the surface; value = depth so far, um
  kHeaterSet = 20,      ///< value = channel x 100000 + 0.01 degC + 10000
};
/// The cause of the end of a valve's list.
enum class FiringEnd : std::uint8_t {
  kThrough = 0,
  kDisarmed = 1,
  kAborted = 2,
  kWatchdog = 3,
  kReboot = 4,
  kReplaced = 5,
  kDisabled = 6
};  ///< kDisabled: by the robot's enable line
struct FiringRecord {
  std::int64_t trigger_us = 0, first_us = 0, last_us = 0, end_us = 0;  ///< first, last: pulses; 0: no pulse
  double volume_mm3 = 0.0;                                             ///< that left the nozzle
  std::uint32_t path = 0, listed = 0, fired = 0;
  std::uint8_t valve = 0;  ///< 0 water, 1 SME
  FiringEnd end = FiringEnd::kThrough;
  std::uint8_t reserved[2] = {};
};
/// Holds the digest of a true surface that the world told the launcher: SIM_TRUTH in the log can be compared.
struct TruthRecord {
  std::int64_t t_us = 0;
  std::array<std::byte, 32> sha256{};  ///< of truth_digest()
};
struct DeviceRecord {
  std::int64_t t_us = 0;
  std::int64_t value = 0;
  Port port = Port::kStage;
  DeviceEvent event = DeviceEvent::kJetArmed;
  std::uint8_t reserved[6] = {};
};

/// Returns the SHA-256 of a true surface as it is sent: layer, droplets, volume, grid (nx, ny, pitch,
/// origin), heights [mm] as single-precision numbers, in this order, little endian.
std::array<std::byte, 32> truth_digest(std::int32_t layer, std::int64_t droplets, double volume_mm3,
                                       const GridSpec& grid, std::span<const float> height_mm);

/// Receives the world's records. Implementations must not throw for lack of speed; shots are cheap calls.
class WorldRecord {
 public:
  virtual ~WorldRecord() = default;
  virtual void append(RecordKind kind, std::span<const std::byte> payload) = 0;
  virtual void flush() {}
};

/// The file. Shots are gathered and written as one kShots record when something else happens, when 256 have
/// gathered, or at flush(). An existing file is continued. @throws as record::RecordWriter
std::unique_ptr<WorldRecord> make_record_file(const std::filesystem::path& path);

/// Holds all records of a file, by kind, each in order of time.
struct WorldHistory {
  std::vector<BeginRecord> begins;
  std::vector<ShotRecord> shots;
  std::vector<ScanRecord> scans;
  std::vector<LampRecord> lamp;
  std::vector<LinkRecord> links;
  std::vector<DeviceRecord> devices;
  std::vector<FiringRecord> firings;
  std::vector<TruthRecord> truths;
  std::size_t damaged = 0;  ///< places where the file was damaged
};
/// @throws std::runtime_error naming the file when it cannot be opened
WorldHistory read_history(const std::filesystem::path& path);
/// Returns the number of events, each shot of a kShots record being one, in undamaged records from byte
/// `from` on. Truths that were asked for are no events.
/// @throws std::runtime_error naming the file when it cannot be opened
std::uint64_t count_events(const std::filesystem::path& path, std::uint64_t from);
/// Adds one record; returns false for a kind or length that is not ours.
bool decode(RecordKind kind, std::span<const std::byte> payload, WorldHistory& into);

}  // namespace firn::plant
