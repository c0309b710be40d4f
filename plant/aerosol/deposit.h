// Deposit lays ink on the substrate as a moving beam: a Gauss section with a wide halo, dried at once.
#pragma once

#include "plant/aerosol/source.h"
#include "plant/inkjet/field.h"

namespace firn::plant {

struct AerosolLedger {
  double passed_mm3 = 0.0, kept_mm3 = 0.0;  ///< ink, by the shutter
  double landed_mm3 = 0.0, lost_mm3 = 0.0;  ///< dry, on and beside the field
};

class Deposit {
 public:
  Deposit(const GridSpec& grid, const AerosolParams& params, std::uint64_t seed);

  /// Place and speed of the nozzle over the part.
  struct Nozzle {
    double x_mm = 0.0, y_mm = 0.0, speed_mm_s = 0.0;
  };
  /// Goes on to t_us; `nozzle_at(us)` is asked at the middles of steps of at most 2 ms, `supply_at(us)` for
  /// the gas of their ends.
  template <class NozzleAt, class SupplyAt>
  void catch_up(std::int64_t t_us, NozzleAt nozzle_at, SupplyAt supply_at) {
    while (source_.at_us() < t_us) {
      const std::int64_t from = source_.at_us(), change = source_.next_change_us();
      std::int64_t to = change > from && change < t_us ? change : t_us;
      if (!source_.quiet() && to - from > kStep_us) to = from + kStep_us;
      const GasSupply gas = supply_at(to);
      source_.supply(gas);
      if (gas.focusing_ratio != ratio_) focus(gas.focusing_ratio);
      const Given given = source_.step(to);
      lay(given, nozzle_at((from + to) / 2), double(to - from) * 1e-6);
    }
  }
  template <class NozzleAt>
  void catch_up(std::int64_t t_us, NozzleAt nozzle_at) {
    const GasSupply nominal{1.0, params_.focusing_ratio, 1.0};
    catch_up(t_us, nozzle_at, [&](std::int64_t) { return nominal; });
  }
  void switch_shutter(bool open, std::int64_t t_us) { source_.switch_shutter(open, t_us); }

  const Source& source() const { return source_; }
  const Field& surface() const { return field_; }
  const AerosolLedger& ledger() const { return ledger_; }
  void io(Archive& a);

 private:
  static constexpr std::int64_t kStep_us = 2000;
  void focus(double ratio);
  void lay(const Given& given, const Nozzle& at, double dt_s);
  void spot(double dry_mm3, double x_mm, double y_mm, double sigma_mm);

  AerosolParams params_;
  double ratio_, sigma_mm_;
  Source source_;
  Field field_;
  AerosolLedger ledger_;
  /// The halo is laid in fewer, larger steps: volume that waits, and its centre.
  double halo_mm3_ = 0.0, halo_x_mm_ = 0.0, halo_y_mm_ = 0.0;
};

}  // namespace firn::plant
