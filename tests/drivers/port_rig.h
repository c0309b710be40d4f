// PortRig holds drivers wired to the simulated world at byte level, in simulated time: two sides written
// independently from the same cards. It is the common part of the rigs of both labs; each rig names its
// drivers.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "drivers/link/driver.h"
#include "plant/world/world.h"

namespace firn::drivers::test {

class MemoryRecord final : public plant::WorldRecord {
 public:
  void append(plant::RecordKind kind, std::span<const std::byte> payload) override {
    plant::decode(kind, payload, history);
  }
  plant::WorldHistory history;
};

class PortRig {
 public:
  virtual ~PortRig() = default;
  using Act = std::function<void(std::int64_t, Effects&)>;
  void act(std::string_view port, const Act& f);
  /// Runs until `done` or the limit; @returns done().
  bool run(const std::function<bool()>& done, double limit_s);
  void run_for(double s) {
    run([] { return false; }, s);
  }
  bool all_safe() const;
  void kill(std::string_view port);    ///< the process dies: the port is closed, the driver does nothing
  void resume(std::string_view port);  ///< the process is back with its state
  void unplug(std::string_view port);  ///< the line is pulled out; nothing opens until open_line() says so

  /// Returns the events of one kind that a driver has reported.
  template <class E>
  std::vector<E> all(std::string_view port) const {
    std::vector<E> out;
    const auto at = events.find(port);
    if (at == events.end()) return out;
    for (const DriverEvent& e : at->second)
      if (const E* p = event_cast<E>(e)) out.push_back(*p);
    return out;
  }
  Driver& driver(std::string_view name) { return *port(name).driver; }

  MemoryRecord record;
  plant::World world;
  std::int64_t now_us = 0;
  std::map<std::string, std::vector<DriverEvent>, std::less<>> events;
  std::map<std::string, std::string, std::less<>> written;

 protected:
  explicit PortRig(const plant::WorldConfig& config) : world(config, &record) {}
  // The line of a rig whose bytes do not go through memory (wire_rig.h).
  virtual bool open_line(std::string_view) { return true; }  ///< false: it cannot be opened now
  virtual void close_line(std::string_view) {}               ///< by the instrument
  virtual std::string to_instrument(std::string_view, std::string bytes) { return bytes; }
  virtual std::string to_host(std::string_view, std::string bytes) { return bytes; }
  void add(std::string name, Driver& driver) { ports_.push_back({std::move(name), &driver}); }
  void connect_all();  ///< and waits until all are SAFE

 private:
  struct Port {
    std::string name;
    Driver* driver;
    std::int64_t wake_us = 0;
    bool connected = false;
    bool dead = false;
  };
  Port& port(std::string_view name);
  void step(Port& p, const std::function<void(Effects&)>& f);

  std::vector<Port> ports_;
};

}  // namespace firn::drivers::test
