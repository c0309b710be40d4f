#include "plant/world/ice_lab.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "plant/twins/firmware_heater.h"
#include "plant/twins/firmware_valve.h"
#include "plant/twins/heater.h"
#include "plant/twins/laser_point.h"
#include "plant/twins/robot.h"
#include "plant/twins/valve.h"
#include "plant/twins/vplus_robot.h"
#include "plant/world/world_lab.h"

namespace firn::plant {
namespace {

class IceWorldLab final : public WorldLab, public IceLab, private IceWires {
 public:
  IceWorldLab(const WorldConfig& c, WorldRecord* r)
      : WorldLab(c, r),
        nature_(c.ice, c.seed),
        robot_(make_robot(c)),
        valve_a_(make_valve(0, c)),
        valve_b_(make_valve(1, c)),
        laser_(c.ice.laser, *this),
        heater_(make_heater(c)) {
    twins = {robot_.get(), valve_a_.get(), valve_b_.get(), &laser_, heater_.get()};
  }

  std::uint32_t milestones() const override { return firings_; }
  std::int64_t begun_with() const override { return nature_.pulses(0) + nature_.pulses(1); }
  const IceLab* ice() const override { return this; }
  const IceNature& nature() const override { return nature_; }
  void catch_up(std::int64_t t_us) override {
    nature_.catch_up(t_us);
    const Collisions& c = nature_.collisions();
    if (c.contacts == contacts_) return;
    contacts_ = c.contacts;
    note(c.last_us, Port::kRobot, DeviceEvent::kScraped, std::int64_t(c.deepest_mm * 1e3));
  }

  Truth truth() const override {
    const IceLedger& l = nature_.bed().ledger();
    const IceFieldParams& f = config.ice.field;
    const int nx = int(f.width_mm), ny = int(f.height_mm);  // whole cells of 1 mm, centred
    const GridSpec grid{
        nx, ny, 1.0, 1.0, f.x0_mm + 0.5 * (f.width_mm - nx) + 0.5, f.y0_mm + 0.5 * (f.height_mm - ny) + 0.5};
    return {firings_,
            nature_.pulses(0) + nature_.pulses(1),
            nature_.dead_pulses(),
            0,
            nature_.bed().volume_mm3(),
            {l.landed[0] + l.landed[1], l.lost, -l.grown},
            height_over(grid),
            {}};
  }
  IceTruth ice_truth() const override {
    IceTruth t;
    t.firings = firings_;
    for (int v = 0; v < 2; ++v) {
      t.pulses[std::size_t(v)] = nature_.pulses(v);
      t.last_pulse_us[std::size_t(v)] = nature_.last_pulse_us(v);
    }
    t.dead_pulses = nature_.dead_pulses();
    t.collisions = nature_.collisions();
    t.ledger = nature_.bed().ledger();
    t.heat = nature_.heat().state();
    t.pose = nature_.arm().newest();
    return t;
  }
  const VplusRobotTwin* vplus_robot() const override {
    return dynamic_cast<const VplusRobotTwin*>(robot_.get());
  }
  double weighed_mg(int material, std::uint32_t weighing) const override {
    const IceBalanceParams& b = config.ice.balance;
    const double true_mg = nature_.bed().ledger().lost * b.density_mg_mm3[std::size_t(material)];
    const double error_mg = b.std_mg * random_normal({config.seed, Purpose::kSensorNoise, 3000, 0, weighing});
    return b.step_mg * std::round((true_mg + error_mg) / b.step_mg);
  }
  void io_plant(Archive& a) override {
    a.all(firings_, contacts_, mask_);
    a.tag(1, "the plant");
    nature_.io(a);
  }

 private:
  std::unique_ptr<Twin> make_robot(const WorldConfig& c) {
    IceWires& wires = *this;
    if (c.ice.robot.texts.empty()) return std::make_unique<RobotTwin>(c.ice.arm, c.seed, c.host_scale, wires);
    return std::make_unique<VplusRobotTwin>(c.ice.arm, c.ice.robot, c.seed, wires);
  }
  std::unique_ptr<ValveBox> make_valve(int valve, const WorldConfig& c) {
    IceWires& wires = *this;
    const IceValveParams& params = c.ice.valve[std::size_t(valve)];
    if (c.ice.make_valve_box) return c.ice.make_valve_box(valve, params, wires);
    if (params.firmware) return std::make_unique<FirmwareValveTwin>(valve, params, c.host_scale, wires);
    return std::make_unique<ValveTwin>(valve, params, c.host_scale, wires);
  }
  std::unique_ptr<Twin> make_heater(const WorldConfig& c) {
    HeaterWires& wires = *this;
    if (c.ice.heater_firmware) return std::make_unique<FirmwareHeaterTwin>(wires);
    return std::make_unique<HeaterTwin>(wires);
  }
  IceNature& nature() override { return nature_; }
  void signals(std::int64_t t_us, int mask) override {
    const int risen = mask & ~mask_, fallen = mask_ & ~mask;
    mask_ = mask;
    if (risen & 1) valve_a_->signal(t_us);
    if (risen & 2) valve_b_->signal(t_us);
    if ((risen | fallen) & 4) laser_.signal(t_us, (risen & 4) != 0);
  }
  void valves_off(std::int64_t t_us) override {
    valve_a_->disable(t_us);
    valve_b_->disable(t_us);
  }
  void link_closed(std::int64_t t_us, Port port) override { note_closed(t_us, port); }
  void note(std::int64_t t_us, Port port, DeviceEvent event, std::int64_t value) override {
    write(RecordKind::kDevice, DeviceRecord{t_us, value, port, event, {}});
  }
  void fired(const FiringRecord& firing) override {
    ++firings_;
    write(RecordKind::kFiring, firing);
  }

  IceNature nature_;
  std::unique_ptr<Twin> robot_;
  std::unique_ptr<ValveBox> valve_a_, valve_b_;
  LaserPointTwin laser_;
  std::unique_ptr<Twin> heater_;
  std::uint32_t firings_ = 0;
  std::int64_t contacts_ = 0;
  int mask_ = 0;
};

std::unique_ptr<WorldLab> make_ice_lab(const WorldConfig& config, WorldRecord* record) {
  return std::make_unique<IceWorldLab>(config, record);
}

std::string ice_fingerprint(const WorldConfig& c) {
  const IceFieldParams& f = c.ice.field;
  char text[200];
  std::snprintf(text, sizeof text, " ice %a %a %a %a %a", f.cell_mm, f.x0_mm, f.y0_mm, f.width_mm,
                f.height_mm);
  return text;
}

}  // namespace

const WorldKind kIceWorld{"ice", kIcePortNames, [](const WorldConfig& c) { check(c.ice); }, &ice_fingerprint,
                          &make_ice_lab};

}  // namespace firn::plant
