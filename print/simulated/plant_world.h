// PlantWorld is the adapter of the simulated world to the Lab's interface LabWorld.
#pragma once

#include <utility>

#include "plant/world/world.h"
#include "runtime/lab.h"

namespace firn {

class PlantWorld : public LabWorld {
 public:
  explicit PlantWorld(plant::World world) : world_(std::move(world)) {}
  void connect(std::string_view port, Time now) override { world_.connect(port, now.us); }
  void disconnect(std::string_view port, Time now) override { world_.disconnect(port, now.us); }
  void receive(std::string_view port, std::span<const std::byte> bytes, Time now) override {
    world_.receive(port, bytes, now.us);
  }
  Time next_event() const override { return {world_.next_event_us()}; }
  void advance(Time now, const Send& send) override {
    world_.advance(now.us,
                   [&](const plant::World::Sent& s) { send(s.port, s.bytes, Time{s.t_us}, s.close); });
  }
  void inject(const plant::SimFault& fault, Time now) { world_.inject(fault, now.us); }
  const plant::World& world() const { return world_; }

 private:
  plant::World world_;
};

}  // namespace firn
