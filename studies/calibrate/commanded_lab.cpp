#include "studies/calibrate/commanded_lab.h"

#include <algorithm>
#include <stdexcept>

#include "config/devices.h"
#include "firn/enable_t.hpp"
#include "firn/fault_t.hpp"
#include "plant/world/setup.h"
#include "print/device/simulated_instruments.h"
#include "print/simulated/plant_world.h"
#include "runtime/wall_clock_ports.h"

namespace firn {
namespace {

constexpr std::int64_t kRunId = 1;

}  // namespace

// The instruments: all simulated in simulated time, or where [devices] has them, the others in a simulated
// lab that runs by the clock.
struct CommandedLab::Instruments {
  explicit Instruments(const Experiment& e) {
    std::map<std::string, PortAddress> all = outside_ports(e);
    if (all.empty()) {
      plant = std::make_unique<PlantWorld>(plant::World(plant::world_config(e), nullptr));
      return;
    }
    const std::vector<std::string> simulated = simulated_ports(e);
    if (!simulated.empty()) beside = std::make_unique<SimulatedInstruments>(e);
    for (const std::string& node : simulated) all.emplace(node, beside->address(node));
    real = std::make_unique<WallClockPorts>(all);
  }
  LabWorld* world() { return plant ? static_cast<LabWorld*>(plant.get()) : real.get(); }

  std::unique_ptr<PlantWorld> plant;
  std::unique_ptr<SimulatedInstruments> beside;
  std::unique_ptr<WallClockPorts> real;
};

CommandedLab::CommandedLab(const Experiment& e, Nodes nodes, const Blobs& inputs)
    : instruments_(std::make_unique<Instruments>(e)), lab_(instruments_->world()) {
  const std::string config = dump(e);
  for (const auto& [id, make] : nodes) {
    hosts_.push_back(std::make_unique<NodeHost>(id, make(config, inputs), kRunId, nullptr));
    if (info(id).driver) drivers_.push_back(id);
    lab_.add(hosts_.back().get());
  }
  lab_.set_tap(
      [this](std::string_view channel, std::span<const std::byte> bytes, Time) { hear(channel, bytes); });
  lab_.start(0, Time{});
}

CommandedLab::~CommandedLab() = default;

const PlantWorld* CommandedLab::simulated() const { return instruments_->plant.get(); }
SimulatedInstruments* CommandedLab::beside() const { return instruments_->beside.get(); }

void CommandedLab::hear(std::string_view channel, std::span<const std::byte> bytes) {
  if (channel == channels::kEnable.name) {
    if (const auto m = decoded<enable_t>(bytes)) {
      epoch_ = m->enable_epoch;
      enabled_ = m->enabled;
    }
  }
  for (const NodeId d : drivers_) {
    if (channel == channels::answer(d).name) {
      if (auto m = decoded<answer_t>(bytes); m && m->command_id == command_id_) answer_ = std::move(m);
    } else if (channel == channels::device_state(d).name) {
      if (const auto m = decoded<device_state_t>(bytes)) states_[d] = DeviceState(m->state);
    } else if (channel == channels::fault(d).name) {
      if (const auto m = decoded<fault_t>(bytes); m && Severity(m->severity) == Severity::kStop)
        stopped_ = m->node + ": " + m->text;
    }
  }
  heard(channel, bytes);
}

bool CommandedLab::step(Time limit, const std::string& what) {
  if (!stopped_.empty()) throw std::runtime_error(what + ": " + stopped_);
  return lab_.step(limit);
}

void CommandedLab::fail_late(const std::string& what, double seconds) {
  std::string ports;
  if (instruments_->real)
    for (const std::string& notice : instruments_->real->take_notices()) ports += "; " + notice;
  throw std::runtime_error(what + " is not done after " + std::to_string(int(seconds)) + " s of lab time" +
                           ports);
}

void CommandedLab::wait(double seconds) {
  const Time limit = lab_.now().after_s(seconds);
  while (lab_.now() < limit && lab_.step(limit))
    if (!stopped_.empty()) throw std::runtime_error(stopped_);
}

void CommandedLab::get_safe(double seconds) {
  until(
      [&] {
        return enabled_ &&
               std::ranges::all_of(drivers_, [&](NodeId d) { return states_[d] == DeviceState::kSafe; });
      },
      seconds, "getting ready");
}

Outbox& CommandedLab::outbox(NodeId node) { return outboxes_.try_emplace(node, node, kRunId).first->second; }

}  // namespace firn
