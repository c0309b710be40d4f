#include "page/run_digest.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "config/devices.h"
#include "files/text_file.h"
#include "firn/lamp_command_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/told_heights.h"
#include "page/recorded_log.h"
#include "print/folder/run_config.h"
#include "replay/run_migration.h"
#include "replay/wal_file.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;

constexpr double kDigestUm = 1e3;  // per mm
constexpr std::string_view kLamp = "lamp";

void add(std::string_view channel, std::span<const std::byte> message, RunDigest& digest) {
  if (channel == channels::kLayerMetrics.name) {
    layer_metrics_t m{};
    if (replay::decode_recorded(message, m) && heights_told(m))
      digest.last = RunDigest::Error{m.rms_mm * kDigestUm, m.mean_error_mm * kDigestUm, m.layer};
  } else if (channel == channels::kLampCommand.name) {
    lamp_command_t m{};
    if (replay::decode_recorded(message, m)) digest.lamp_open_s += m.exposure_s;
  }
}

bool add_log(const fs::path& run, RunDigest& digest) {
  const auto log =
      RecordedLog::open(run, {std::string(channels::kLayerMetrics.name),
                              std::string(channels::kLampCommand.name), std::string(channels::kRunEnd.name)});
  if (!log) return false;
  log->each([&](std::string_view channel, std::span<const std::byte> message, Place) {
    add(channel, message, digest);
  });
  return true;
}

// The scheduler sends both.
void add_write_ahead_file(const fs::path& run, RunDigest& digest) {
  replay::WalFile file(run / "nodes" / "scheduler.wal");
  std::vector<Output> outputs;
  for (auto item = file.next(); item != replay::WalFile::Item::kEnd; item = file.next()) {
    if (item != replay::WalFile::Item::kStep || !file.step().has_outputs || file.step().damaged_at) continue;
    decode_output_list(file.step().outputs, outputs);
    for (const Output& o : outputs)
      if (o.kind == OutputKind::kSend) add(o.channel, o.bytes, digest);
  }
}

}  // namespace

RunDigest digest_run(const fs::path& run) try {
  RunDigest digest;
  digest.lamp = lamp_of(run);
  if (!add_log(run, digest)) add_write_ahead_file(run, digest);
  return digest;
} catch (const std::runtime_error&) {
  return {};
}

std::string lamp_of(const fs::path& run) try {
  const fs::path file = run / "experiment.toml";
  const std::string recorded = recorded_config(run);
  const Experiment e =
      parse_recorded_experiment(recorded.empty() ? read_file(file) : recorded, file.string());
  if (std::ranges::count(simulated_ports(e), kLamp) > 0) return "simulated";
  return outside_ports(e).contains(std::string(kLamp)) ? port_text(e.devices, kLamp) : "";
} catch (const std::exception&) {
  return "";
}

}  // namespace firn::page
