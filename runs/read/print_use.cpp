#include "runs/read/print_use.h"

#include <algorithm>
#include <array>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "config/devices.h"
#include "config/labs.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "firn/lamp_command_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "lcmtypes/channels.h"
#include "runs/folder/config_change.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/run_reader.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr double kSecondsPerHour = 3600.0;

// Phases of a layer in which an instrument works.
struct Works {
  std::string_view node;
  bool deposits = false, scans = false, always = false;
};
constexpr std::array kWorks{
    Works{"jet", true},
    Works{"jet_b", true},
    Works{"valve_a", true},
    Works{"valve_b", true},
    Works{"gas", true},
    Works{"stage", true, true},
    Works{"robot", true, true},
    Works{"laser_profiler", false, true},
    Works{"laser_point", false, true},
    Works{"heater", false, false, true},
    Works{"camera", false, false, true},
};

struct Sums {
  double deposit_s = 0.0, scan_s = 0.0, lamp_s = 0.0, whole_s = 0.0;
  double first_mm3 = 0.0, last_mm3 = 0.0;
  bool measured = false;
  std::int64_t amount = 0;
};

void add_work(std::string_view channel, std::span<const std::byte> message, Sums& s) {
  if (channel == channels::kLampCommand.name) {
    lamp_command_t m{};
    if (decode_recorded(message, m)) s.lamp_s += m.exposure_s;
    return;
  }
  layer_metrics_t m{};
  if (channel != channels::kLayerMetrics.name || !decode_recorded(message, m)) return;
  s.deposit_s += m.deposit_s;
  s.scan_s += m.scan_s;
  s.amount = std::max(s.amount, m.drops_total);
  s.whole_s = std::max(s.whole_s, double(m.header.utime_us) * 1e-6);
  if (!std::exchange(s.measured, true)) s.first_mm3 = m.volume_mm3;
  s.last_mm3 = m.volume_mm3;
}

// A droplet raises its cell by h1, four cells by h2 and four by h3 [Lu 2015, (1)]; a pulse gives the inverse
// of the pulses per volume [Barnett 2012, (5.14)]; a line has no such unit.
double volume_of(const Experiment& e, const Sums& s) {
  switch (lab_of(e).deposition) {
    case Deposition::kDroplets:
      return double(s.amount) * (e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm) *
             e.grid.pitch_x_mm * e.grid.pitch_y_mm;
    case Deposition::kPaths:
      return double(s.amount) / e.valve_a.hz_per_mm3_s;
    case Deposition::kLines:
      break;
  }
  return std::max(0.0, s.last_mm3 - s.first_mm3);
}

Experiment experiment_of(const fs::path& run) {
  const fs::path file = RunPaths(run).experiment_path();
  const std::string recorded = recorded_config(run);
  return parse_recorded_experiment(recorded.empty() ? read_file(file) : recorded, file.string());
}

double hours_of(std::string_view node, const Sums& s) {
  if (node == "lamp") return s.lamp_s / kSecondsPerHour;
  const auto works = std::ranges::find(kWorks, node, &Works::node);
  if (works == kWorks.end()) return 0.0;
  if (works->always) return s.whole_s / kSecondsPerHour;
  return (works->deposits * s.deposit_s + works->scans * s.scan_s) / kSecondsPerHour;
}

}  // namespace

std::optional<PrintUse> print_use(const fs::path& run) try {
  const Experiment e = experiment_of(run);
  Sums sums;
  RunReader reader(run,
                   {std::string(channels::kLayerMetrics.name), std::string(channels::kLampCommand.name),
                    std::string(channels::kRunEnd.name)},
                   RunReader::Source::kLog);
  reader.poll([&](std::string_view channel, std::span<const std::byte> message, Place) {
    add_work(channel, message, sums);
  });
  PrintUse use;
  use.amount = sums.amount;
  use.volume_mm3 = volume_of(e, sums);
  const auto simulated = simulated_ports(e);
  const auto outside = outside_ports(e);
  for (const DevicePort& port : kDevicePorts) {
    const std::string node(port.node);
    const bool is_simulated = std::ranges::find(simulated, node) != simulated.end();
    if (!is_simulated && !outside.contains(node)) continue;
    InstrumentUse i{is_simulated ? "simulated" : port_text(e.devices, node), hours_of(node, sums), 0.0};
    const bool deposits = node == "jet" || node == "valve_a" || node == "gas";
    if (deposits && use.depositing.empty()) {
      use.depositing = node;
      i.volume_mm3 = use.volume_mm3;
    }
    use.instruments.emplace(node, std::move(i));
  }
  if (use.instruments.empty()) return std::nullopt;
  return use;
} catch (const std::exception&) {
  return std::nullopt;
}

}  // namespace firn::runs
