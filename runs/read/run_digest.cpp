#include "runs/read/run_digest.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "config/devices.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "firn/lamp_command_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/told_heights.h"
#include "runs/folder/config_change.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/run_reader.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr double kDigestUm = 1e3;  // per mm
constexpr std::string_view kLamp = "lamp";

void add(std::string_view channel, std::span<const std::byte> message, RunDigest& digest) {
  if (channel == channels::kLayerMetrics.name) {
    layer_metrics_t m{};
    if (runs::decode_recorded(message, m) && heights_told(m))
      digest.last = RunDigest::Error{m.rms_mm * kDigestUm, m.mean_error_mm * kDigestUm, m.layer};
  } else if (channel == channels::kLampCommand.name) {
    lamp_command_t m{};
    if (runs::decode_recorded(message, m)) digest.lamp_open_s += m.exposure_s;
  }
}

}  // namespace

RunDigest digest_run(const fs::path& run) try {
  RunDigest digest;
  digest.lamp = lamp_of(run);
  RunReader reader(run,
                   {std::string(channels::kLayerMetrics.name), std::string(channels::kLampCommand.name),
                    std::string(channels::kRunEnd.name)},
                   RunReader::Source::kLog);
  const bool there = reader.poll([&](std::string_view channel, std::span<const std::byte> message, Place) {
    add(channel, message, digest);
  });
  return there ? digest : RunDigest{};
} catch (const std::runtime_error&) {
  return {};
}

std::string lamp_of(const fs::path& run) try {
  const fs::path file = RunPaths(run).experiment_path();
  const std::string recorded = recorded_config(run);
  const Experiment e =
      parse_recorded_experiment(recorded.empty() ? read_file(file) : recorded, file.string());
  if (std::ranges::count(simulated_ports(e), kLamp) > 0) return "simulated";
  return outside_ports(e).contains(std::string(kLamp)) ? port_text(e.devices, kLamp) : "";
} catch (const std::exception&) {
  return "";
}

}  // namespace firn::runs
