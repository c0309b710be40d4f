#include "print/device/simulated_instruments.h"

#include <unistd.h>

#include <stdexcept>
#include <string>
#include <string_view>

#include "config/device_kinds.h"
#include "config/fields.h"
#include "core/options/number.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr int kBeginWithin_ms = 10'000;

}  // namespace

SimulatedInstruments::SimulatedInstruments(const Experiment& experiment, bool quick) : folder_("device") {
  Experiment alone = experiment;
  alone.devices = {};  // all are at the simulated ports, as the kinds that have a twin
  for (const auto& [node, kind] : experiment.devices.kind)
    if (!is_python_driver(experiment, node)) alone.devices.kind[node] = kind;
  write_file_atomically(RunPaths(folder_.path()).experiment_path(), dump(alone));
  const fs::path beside = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path program = fs::exists(beside / "world") ? beside / "world" : beside / ".." / "bin" / "world";
  std::vector<std::string> words{"--run",        folder_.path().string(),
                                 "--epoch-ns",   std::to_string(monotonic_ns()),
                                 "--control-fd", std::to_string(ChildProcess::kControlFd)};
  if (quick) words.insert(words.end(), {"--instruments", "quick"});
  world_ = std::make_unique<ChildProcess>("world", program, words, folder_ / "world.err");
  for (int ms = 0; ms < kBeginWithin_ms; ++ms) {
    if (const fs::path io = RunPaths(folder_.path()).ports_path(); fs::exists(io) && !fs::is_empty(io))
      return;
    if (!world_->running()) break;
    ::usleep(1000);
  }
  throw std::runtime_error("the simulated lab did not begin");
}

SimulatedInstruments::~SimulatedInstruments() = default;

void SimulatedInstruments::inject(const std::string& fault) { world_->control().say("SIMFAULT " + fault); }

double SimulatedInstruments::weighed_mg(int material, int weighing) {
  constexpr std::string_view kWeighed = "WEIGHED ";
  world_->control().say("WEIGH " + std::to_string(material) + " " + std::to_string(weighing));
  for (int ms = 0; ms < kBeginWithin_ms && world_->running(); ++ms) {
    while (const auto line = world_->control().next()) {
      if (line->starts_with(kWeighed))
        return whole_number<double>(std::string_view(*line).substr(kWeighed.size())).value();
      if (line->starts_with("ERROR")) throw std::runtime_error(*line);
    }
    ::usleep(1000);
  }
  throw std::runtime_error("the simulated lab's balance does not answer");
}

PortAddress SimulatedInstruments::address(const std::string& node) const {
  return unix_port(RunPaths(folder_.path()).port_path(node).string());
}

}  // namespace firn
