// World computes nature for the whole lab: plant, the instruments' twins and the wires between them. Time and
// bytes are its input, bytes its output; only save() and restore() access a file, and no function reads a
// clock.
//
// Kinds of labs (WorldConfig::kind): ink-jet, described here, and ice (docs/plant-ice.md).
// Wires: stage PSO on X -> trigger of both jets -> droplet of each jet that is set to external triggers, at
// its nozzle's position of that instant; PSO on Y -> profiler trigger; lamp shutter -> curing. A world
// without two inks has no second jet on its wires.
// Frames: part = stage (the nozzle of ink A is above part point (x, y) when X = x, Y = y, that of ink B above
// (x + nozzle_b_x, y + nozzle_b_y)).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "core/grid/grid.h"
#include "core/grid/material_columns.h"
#include "plant/config/world_config.h"
#include "plant/inkjet/model.h"
#include "plant/record/ports.h"
#include "plant/record/record.h"
#include "plant/twins/fault.h"

namespace firn::plant {

class WorldLab;
class IceLab;

/// Holds true values that no node may know. In the ice lab: firings of a valve that are over, pulses, pulses
/// without a drop; heights over the whole simulated surface on 1 mm cells. Its own truth: World::ice(),
/// plant/world/ice_lab.h.
struct Truth {
  std::uint32_t exposures = 0;      ///< layers cured
  std::int64_t droplets_fired = 0;  ///< triggers that the jet obeyed, missed droplets included
  std::int64_t droplets_missed = 0;
  std::int64_t triggers_gated = 0;  ///< triggers that the jet did not obey
  double volume_mm3 = 0.0;          ///< on the field
  VolumeLedger ledger;
  HeightMap height;  ///< noise-free mean over each cell [mm]
  HeightMap wide;    ///< the same, and the cells of a margin around the grid; droplets only
  std::array<double, 2> gas_set_sccm = {};  ///< set points in force: atomizer, sheath
  double platen_set_degC = 0.0;             ///< set point in force
  std::vector<Validity> validity = {};      ///< of the theory behind the nature; empty: it has no limits
  HeightMap fine = {};  ///< `wide` on the model's own cells; empty: it has none between them
};

class World {
 public:
  /// Holds bytes of one port that are due at `t_us`; an empty span with `close` = the instrument closes the
  /// port.
  struct Sent {
    std::string_view port;
    std::int64_t t_us = 0;
    std::span<const std::byte> bytes;
    bool close = false;
  };
  using SendFn = std::function<void(const Sent&)>;

  /// @param record may be null; must outlive the world. @throws std::invalid_argument: see check(WorldConfig)
  World(const WorldConfig& config, WorldRecord* record);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// The time of calls of these four must not decrease. Events due before `now_us` happen first; bytes of
  /// instruments that fall due meanwhile wait for advance(). Unknown ports: std::invalid_argument.
  void connect(std::string_view port, std::int64_t now_us);
  void disconnect(std::string_view port, std::int64_t now_us);
  void receive(std::string_view port, std::span<const std::byte> bytes, std::int64_t now_us);
  void inject(const SimFault& fault, std::int64_t now_us);
  /// Every instrument loses its power and starts again, now.
  void lose_power();

  /// Returns the time at which the next bytes for a port fall due; INT64_MAX: no bytes pending. Inner events
  /// (droplets, exposures) need no call of their own: the next call computes them at their exact times.
  std::int64_t next_event_us() const;
  /// Returns the time of the next event, inner or outer: for a live process that records promptly.
  std::int64_t next_inner_us() const;
  /// Runs everything due up to and including `now_us` in order of time and hands over the bytes.
  void advance(std::int64_t now_us, const SendFn& send);

  Truth truth() const;
  MaterialColumns materials() const;  ///< see Model::materials(); apart from truth(), for its size
  std::uint32_t exposures() const;
  std::int64_t now_us() const;                      ///< time of the last call
  std::span<const std::string_view> ports() const;  ///< of this lab
  const IceLab* ice() const;                        ///< null in the ink-jet lab
  const WorldConfig& config() const;

  /// Writes the complete state atomically (temporary file, fsync, rename). @throws std::runtime_error naming
  /// the file
  void save(const std::filesystem::path& path) const;
  /// Returns a world that continues bit for bit from the state saved at `path`. Its ports are disconnected,
  /// unless `links_kept`: then they and the bytes in transit are those of the moment of saving.
  /// The configuration must be that of the saved world.
  /// @throws std::runtime_error: no such file, damaged, or of another configuration
  static World restore(const std::filesystem::path& path, const WorldConfig& config, WorldRecord* record,
                       bool links_kept = false);

 private:
  std::unique_ptr<WorldLab> impl_;
};

}  // namespace firn::plant
