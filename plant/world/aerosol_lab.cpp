#include "plant/world/aerosol_lab.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include "plant/aerosol/deposit.h"
#include "plant/aerosol/line_picture.h"
#include "plant/config/range.h"
#include "plant/ice/heat.h"
#include "plant/inkjet/sensor.h"
#include "plant/inkjet/strobe_scene.h"
#include "plant/twins/camera.h"
#include "plant/twins/heater.h"
#include "plant/twins/laser_profiler.h"
#include "plant/twins/stage.h"
#include "plant/world/world_lab.h"

namespace firn::plant {
namespace {

constexpr std::array kAerosolPorts{kStagePort, kProfilerPort, kGasPort, kHeaterPort, kCameraPort};
constexpr double kHottest_degC = 150.0, kRoom_degC = 22.0;
constexpr double kMaxFocused = 100.0, kMin_sccm = 1e-3;
constexpr double kMaxTurn = 5.0 * std::numbers::pi / 180.0;

// Bilinear between the fine cells' middles; 0 beside the field.
double thickness_at(const Field& f, double x_mm, double y_mm) {
  const double u = (x_mm - f.left_mm()) / f.dx_mm() - 0.5, v = (y_mm - f.bottom_mm()) / f.dy_mm() - 0.5;
  if (!(u >= 0.0 && v >= 0.0 && u < f.width() - 1.0 && v < f.height() - 1.0)) return 0.0;
  const int a = int(u), b = int(v);
  const auto at = [&](int i, int j) {
    return f.surface_mm(std::size_t(j) * std::size_t(f.width()) + std::size_t(i));
  };
  const double s = u - a, t = v - b;
  return (1 - t) * ((1 - s) * at(a, b) + s * at(a + 1, b)) +
         t * ((1 - s) * at(a, b + 1) + s * at(a + 1, b + 1));
}

// The gain scales the light; the exposure does not, since the lamp flashes.
LineCamera line_camera(const WorldConfig& config, const AerosolParams& p, const Exposure& exposure) {
  LineCamera c;
  set_optics(config, 12, c);
  c.turn = p.camera_turn;
  c.light *= std::pow(10.0, exposure.gain_db / 20);
  c.optical_depth_mm = p.optical_depth_mm;
  return c;
}

const AerosolWorldConfig& own_of(const WorldConfig& c) {
  return std::any_cast<const AerosolWorldConfig&>(c.own);
}
const AerosolParams& params_of(const WorldConfig& c) { return own_of(c).nozzle; }

// One section of the ice lab's three is the platen, 60 W on 150 J/K in a room.
IceWorldConfig platen() {
  IceWorldConfig c;
  c.heat.ambient_degC = c.heat.start_degC = kRoom_degC;
  c.heat.capacity_J_K = {150.0, 150.0, 150.0};
  c.heat.loss_W_K = {0.4, 0.4, 0.4};
  c.heat.link_W_K = {0.0, 0.0};
  c.heat.heater_W = {60.0, 0.0, 0.0};
  c.heat.set_degC = {-50.0, -50.0, -50.0};
  return c;
}

class AerosolLab final : public WorldLab, private Wires, private HeaterWires {
 public:
  AerosolLab(const WorldConfig& c, WorldRecord* r)
      : WorldLab(c, r),
        deposit_(c.grid, params_of(c), c.seed),
        stage_(c.stage, *this),
        profiler_(make_profile_sensor(c.grid, c.profiler, [this](std::int64_t t_us) { return look(t_us); })),
        gas_(Port::kGas, own_of(c).gas, *this),
        heat_(platen()),
        heater_(*this, kHottest_degC),
        camera_({}, [this](const Exposure& e) { return picture(e); }),
        line_(std::size_t(c.profiler.points)) {
    twins = {&stage_, profiler_.get(), &gas_, &heater_, &camera_};
  }

  std::uint32_t milestones() const override { return layers_; }
  bool pulses_speak() const override { return profiler_->speaks_at_pulses(); }
  std::int64_t begun_with() const override { return switches_; }
  Truth truth() const override {
    const AerosolLedger& l = deposit_.ledger();
    return {layers_,
            switches_,
            0,
            0,
            deposit_.surface().volume_mm3(),
            {l.landed_mm3 + l.lost_mm3, l.lost_mm3, 0.0},
            deposit_.surface().cell_means(),
            deposit_.surface().means_with_margin(),
            gas_.set_sccm(),
            heat_.set_degC(0)};
  }
  void io_plant(Archive& a) override {
    a.all(layers_, switches_, scans_, firing_);
    a.tag(1, "the plant");
    deposit_.io(a);
    heat_.io(a);
  }
  void catch_up(std::int64_t t_us) override {
    const auto nozzle_at = [&](std::int64_t at_us) {
      const Vec3 p = stage_.device().position_mm(at_us);
      return Deposit::Nozzle{
          p[0], p[1],
          std::hypot(stage_.device().velocity_mm_s(0, at_us), stage_.device().velocity_mm_s(1, at_us))};
    };
    if (!params_of(config).gas) return deposit_.catch_up(t_us, nozzle_at);
    deposit_.catch_up(t_us, nozzle_at, [&](std::int64_t at_us) { return supply(at_us); });
    gas_.narrow(deposit_.source().open_share());
  }

 private:
  Heat& heat() override { return heat_; }

  GasSupply supply(std::int64_t at_us) {
    const AerosolWorldConfig& own = own_of(config);
    const double atomizer = gas_.sccm(0, at_us), sheath = gas_.sccm(1, at_us);
    const double nominal = own.sheath_sccm / own.atomizer_sccm;
    return {
        atomizer / own.atomizer_sccm,
        std::min(kMaxFocused, own.nozzle.focusing_ratio * sheath / std::max(kMin_sccm, atomizer) / nominal),
        gas_.open_share()};
  }

  void pulse(int axis, std::int64_t t_us, const double position_mm[3], const double[3]) override {
    if (axis == 1) return scan(t_us, position_mm[0], position_mm[1]);
    if (axis != 0) return;
    ++switches_;
    ++firing_.fired;
    if (firing_.first_us == 0) firing_.first_us = t_us;
    firing_.last_us = t_us;
    if (!stage_.device().shutter_jammed()) deposit_.switch_shutter(!deposit_.source().commanded_open(), t_us);
  }

  void scan(std::int64_t t_us, double stage_x_mm, double stage_y_mm) {
    catch_up(t_us);
    const double y_mm = stage_y_mm + config.profiler.laser_offset_y_mm;
    const auto encoder = std::int32_t(stage_.device().encoder_counts(1, stage_y_mm));
    measure(stage_x_mm, stage_y_mm, scans_++);
    profiler_->trigger(t_us, encoder, line_);
    write(RecordKind::kScanTrigger, ScanRecord{t_us, y_mm, profiler_->triggers(), encoder});
  }

  /// The head's view with the stage there, into line_. @param number of the measurement of this layer
  void measure(double stage_x_mm, double stage_y_mm, std::uint32_t number) {
    const ProfilerParams& p = config.profiler;
    const GridSpec& g = config.grid;
    const double shift_mm = stage_x_mm - 0.5 * (g.x_mm(0) + g.x_mm(g.nx - 1));
    measure_profile(deposit_.surface(), config.sensor, {config.seed, layers_, number},
                    stage_y_mm + p.laser_offset_y_mm + p.error_y_mm,
                    profile_x0_mm(g, p) + p.laser_offset_x_mm + p.error_x_mm +
                        (std::abs(shift_mm) < 1e-3 ? 0.0 : shift_mm),
                    profile_dx_mm(g, p), line_);
  }

  /// Of a person's question between the pulses: its noise is that of the time.
  double look(std::int64_t t_us) {
    constexpr std::uint32_t kBesidePulses = 0x8000'0000u;
    catch_up(t_us);
    const Vec3 at = stage_.device().position_mm(t_us);
    measure(at[0], at[1], kBesidePulses | std::uint32_t(t_us));
    return line_[0];
  }

  TakenPicture picture(const Exposure& e) {
    catch_up(e.t_us);
    const AerosolParams& p = params_of(config);
    LineCamera c = line_camera(config, p, e);
    const Vec3 at = stage_.device().position_mm(e.t_us);
    c.x_mm = at[0] + p.camera_x_mm;
    c.y_mm = at[1] + p.camera_y_mm;
    const InkThickness thickness = [&](std::span<const double> x_mm, std::span<const double> y_mm,
                                       std::span<double> ink_mm) {
      for (std::size_t n = 0; n < ink_mm.size(); ++n)
        ink_mm[n] = thickness_at(deposit_.surface(), x_mm[n], y_mm[n]);
    };
    return render_lines(c, thickness, config.seed, e.number);
  }

  // The output rests where the shutter is closed.
  void output_off(std::int64_t t_us) {
    if (deposit_.source().commanded_open() && !stage_.device().shutter_jammed())
      deposit_.switch_shutter(false, t_us);
    if (firing_.trigger_us == 0) return;
    firing_.end_us = t_us;
    if (firing_.fired > 0) {
      if (firing_.fired % 2 == 1) firing_.last_us = t_us;
      ++layers_;
      scans_ = 0;
    }
    write(RecordKind::kFiring, firing_);
    firing_ = {};
  }

  void note(std::int64_t t_us, Port port, DeviceEvent event, std::int64_t value) override {
    write(RecordKind::kDevice, DeviceRecord{t_us, value, port, event, {}});
    if (port != Port::kStage) return;
    if (event == DeviceEvent::kPsoArmed && value == 0) firing_ = {.trigger_us = t_us};
    if ((event == DeviceEvent::kPsoOff && value == 0) || event == DeviceEvent::kRebooted) output_off(t_us);
  }

  void softtrigger(std::int64_t, Port, int) override {}
  void lamp(std::int64_t, LampEvent, double) override {}
  void link_closed(std::int64_t t_us, Port port) override { note_closed(t_us, port); }

  Deposit deposit_;
  StageTwin stage_;
  std::unique_ptr<ProfileSensor> profiler_;
  GasTwin gas_;
  Heat heat_;
  HeaterTwin heater_;
  CameraTwin camera_;
  std::vector<double> line_;
  std::uint32_t layers_ = 0, scans_ = 0;
  std::int64_t switches_ = 0;
  FiringRecord firing_;
};

void check_aerosol(const WorldConfig& c) {
  firn::check(c.grid);
  const AerosolParams& p = params_of(c);
  require_above("aerosol.flow_mm3_s", p.flow_mm3_s, 0.0, 10.0);
  require_above("aerosol.solids", p.solids, 0.0, 1.0);
  require_within("aerosol.flow", p.flow, 0.2, 3.0);
  require_within("aerosol.drift", p.drift, -1.0, 1.0);  // the given one and the drawn one
  require_within("aerosol.drift_s", p.drift_s, 1.0, 1e6);
  require_within("aerosol.wander", p.wander, 0.0, 0.2);
  require_within("aerosol.clog_per_h", p.clog_per_h, 0.0, 5.0);
  require_within("aerosol.vial_h", p.vial_s / 3600.0, 0.1, 1000.0);
  require_within("aerosol.level_loss", p.level_loss, 0.0, 1.0);
  require_within("aerosol.tube_per_h", p.tube_per_h, 0.0, 5.0);
  require_within("aerosol.open_delay_s", p.open_delay_s, 0.0, 0.3);
  require_within("aerosol.close_delay_s", p.close_delay_s, 0.0, 0.3);
  require_above("aerosol.tail_s", p.tail_s, 0.0, 0.3);
  require_within("aerosol.blob_s", p.blob_s, 0.0, 1.0);
  require_within("aerosol.nozzle_mm", p.nozzle_mm, 0.02, 2.0);
  require_within("aerosol.focusing_ratio", p.focusing_ratio, 0.2, 20.0);
  require_within("aerosol.overspray", p.overspray, 0.0, 0.5);
  require_within("aerosol.halo", p.halo, 1.5, 10.0);
  require_above("aerosol.optical_depth_mm", p.optical_depth_mm, 0.0, 1.0);
  require_within("aerosol.camera_turn", p.camera_turn, -kMaxTurn, kMaxTurn);
  require_within("stage.servo_hz", c.stage.servo_hz, 0.0, 1000.0);
  require_within("stage.servo_damping", c.stage.servo_damping, 0.1, 5.0);
  require_within("stage.servo_feed_forward", c.stage.servo_feed_forward, 0.0, 1.2);
  require_within("gas.atomizer_sccm", own_of(c).atomizer_sccm, 1e-3, 1e6);
  require_within("gas.sheath_sccm", own_of(c).sheath_sccm, 1e-3, 1e6);
  require_within("profiler.points", c.profiler.points, c.profiler.point ? 1 : 2, 800);
  require_within("stage.counts_per_mm", c.stage.counts_per_mm, 1.0, 1e7);
}

std::string aerosol_fingerprint(const WorldConfig& c) {
  const AerosolParams& p = params_of(c);
  char text[160];
  std::snprintf(text, sizeof text, " aerosol %a %a %a %a", p.nozzle_mm, p.focusing_ratio, p.halo,
                p.flow_mm3_s);
  return text;
}

std::unique_ptr<WorldLab> make_aerosol_lab(const WorldConfig& config, WorldRecord* record) {
  return std::make_unique<AerosolLab>(config, record);
}

}  // namespace

const WorldKind kAerosolWorld{"aerosol", kAerosolPorts, &check_aerosol, &aerosol_fingerprint,
                              &make_aerosol_lab};

}  // namespace firn::plant
