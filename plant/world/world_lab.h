// WorldLab holds the parts of World common to all labs: twins by port, events in order of time, the record.
// The labs (plant/world/inkjet_lab.cpp, ice_lab.cpp, aerosol_lab.cpp) add the plant and the hardware lines.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "plant/twins/twin.h"
#include "plant/world/world.h"

namespace firn::plant {

class WorldLab {
 public:
  WorldLab(const WorldConfig& c, WorldRecord* r) : config(c), record(r) {}
  virtual ~WorldLab() = default;
  WorldLab(const WorldLab&) = delete;  // twins and wires refer to it

  std::span<const std::string_view> ports() const { return config.kind->ports; }
  virtual std::uint32_t milestones() const = 0;  ///< Truth::exposures
  virtual std::int64_t begun_with() const = 0;   ///< BeginRecord::droplets_before
  virtual Truth truth() const = 0;
  virtual MaterialColumns materials() const { return {}; }
  virtual const IceLab* ice() const { return nullptr; }
  /// A pulse on a hardware line may make an instrument send bytes.
  virtual bool pulses_speak() const { return false; }
  virtual void io_plant(Archive& a) = 0;
  /// Computes the plant's events up to and including t_us: called before every event of a twin and at every
  /// call of World.
  virtual void catch_up(std::int64_t) {}

  /// Executes inner events in order of time; at equal times in the order of the ports.
  void run_until(std::int64_t t_us);
  void begin(bool restored);
  void drop_link(std::size_t port, std::int64_t t_us);
  void note_closed(std::int64_t t_us, Port port) {
    write(RecordKind::kLink, LinkRecord{t_us, port, 0, 1, {}});
  }
  Port port_at(std::size_t n) const;  ///< as the record numbers it
  void io(Archive& a);

  template <class T>
  void write(RecordKind kind, const T& r) {
    if (record) record->append(kind, std::as_bytes(std::span(&r, 1)));
  }

  WorldConfig config;
  WorldRecord* record;
  std::vector<Twin*> twins;  ///< in the order of ports()
  std::int64_t now_us = 0;
};

}  // namespace firn::plant
