// GasTwin simulates two Alicat mass-flow controllers on one serial line, and the nozzle behind them: the
// gases meet in it, so that what it holds back is the pressure of both. Ink that flows without a sheath clogs
// it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "plant/twins/twin.h"

namespace firn::plant {

struct GasParams {
  std::string units = "AB";  ///< atomizer, sheath
  std::string gas = "N2";
  double full_sccm[2] = {100.0, 500.0};
  double settle_s = 0.3;  ///< time constant of a flow
  double open_kpa_per_sccm = 0.02;
  double clog_per_s = 0.05;  ///< growth of the nozzle's resistance by ink without a sheath
  bool gp_firmware = false;  ///< understands commands behind "$$" alone
  double baud = 19200.0;
};

class GasTwin : public Twin {
 public:
  GasTwin(Port port, GasParams params, Wires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { line_.clear(); }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  /// The set points are gone: a controller that gets its power starts closed.
  void reboot(std::int64_t now_us) override;
  /// 1 no atomizer gas, 2 no sheath gas, 3 the nozzle clogs by itself, 4 set points come from the analog
  /// input, 5 the atomizer's valve is held, 6 the sheath's unit says nothing, 7 it is unit C
  void trip(std::int64_t now_us, std::int64_t code) override;
  void io(Archive& a) override {
    a.all(boot_count_, line_, sccm_, set_sccm_, clog_, open_share_, at_us_, trip_, link_);
  }
  /// The share of the nozzle's section that ink has left open.
  void narrow(double open_share) { open_share_ = open_share; }

  /// Truth, brought up to now.
  double sccm(int controller, std::int64_t now_us);
  double nozzle_kpa(std::int64_t now_us);
  const std::array<double, 2>& set_sccm() const { return set_sccm_; }
  /// The share of the nozzle's section that is open after ink without a sheath: a laminar flow's resistance
  /// goes with the square of the section.
  double open_share() const { return 1.0 / std::sqrt(clog_); }

 private:
  void advance(std::int64_t now_us);
  std::string execute(std::string_view line, std::int64_t now_us);
  std::string data(int controller, std::int64_t now_us);
  std::string set(int controller, std::string_view value, std::int64_t now_us);

  GasParams params_;
  Wires& wires_;
  std::string line_;
  std::array<double, 2> sccm_{}, set_sccm_{};
  double clog_ = 1.0;        ///< resistance of the nozzle, 1 = clean
  double open_share_ = 1.0;  ///< and of all else that has narrowed it
  std::int64_t at_us_ = 0, trip_ = 0;
};

}  // namespace firn::plant
