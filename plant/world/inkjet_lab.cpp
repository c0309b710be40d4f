#include <array>
#include <cmath>
#include <vector>

#include "plant/inkjet/instrument_faults.h"
#include "plant/inkjet/sensor.h"
#include "plant/inkjet/strobe_scene.h"
#include "plant/twins/camera.h"
#include "plant/twins/grbl.h"
#include "plant/twins/jet.h"
#include "plant/twins/lamp.h"
#include "plant/twins/laser_profiler.h"
#include "plant/twins/microdrop.h"
#include "plant/twins/stage.h"
#include "plant/world/world_lab.h"

namespace firn::plant {
namespace {

std::unique_ptr<JetTwin> make_jet(Port port, const JetParams& params, Wires& wires) {
  if (params.kind == "microdrop") return std::make_unique<MicrodropTwin>(port, params, wires);
  return std::make_unique<JetTwin>(port, params, wires);
}

struct StageParts {
  std::unique_ptr<Twin> twin;
  const StagePlace* place = nullptr;  ///< of the twin
};

StageParts make_stage(const StageParams& params, Wires& wires) {
  if (params.kind == "grbl") {
    auto twin = std::make_unique<GrblTwin>(params, wires);
    const StagePlace* place = twin.get();
    return {std::move(twin), place};
  }
  auto twin = std::make_unique<StageTwin>(params, wires);
  const StagePlace* place = &twin->device();
  return {std::move(twin), place};
}

class InkjetLab final : public WorldLab, private Wires {
 public:
  InkjetLab(const WorldConfig& c, WorldRecord* r)
      : WorldLab(c, r),
        model_(make_model(c)),
        stage_(make_stage(c.stage, *this)),
        jet_(make_jet(Port::kJet, c.jet, *this)),
        profiler_(make_profile_sensor(c.grid, c.profiler, [this](std::int64_t t_us) { return look(t_us); })),
        lamp_twin_(c.lamp, *this),
        jet_b_(make_jet(Port::kJetB, c.jet_b, *this)),
        camera_({}, [this](const Exposure& e) { return picture(e); }),
        nozzles_{NozzleFault(c.nozzle_faults), NozzleFault(c.nozzle_faults)},
        line_(std::size_t(c.profiler.points)) {
    twins = {stage_.twin.get(), jet_.get(), profiler_.get(), &lamp_twin_, jet_b_.get(), &camera_};
  }

  std::uint32_t milestones() const override { return model_->layers().exposures(); }
  bool pulses_speak() const override { return profiler_->speaks_at_pulses(); }
  std::int64_t begun_with() const override { return fired_; }
  Truth truth() const override {
    return {model_->layers().exposures(),
            fired_,
            missed_,
            gated_,
            model_->volume_mm3(),
            model_->ledger(),
            model_->cell_means(),
            model_->means_with_margin(),
            {},
            0.0,
            model_->validity(),
            model_->fine_surface()};
  }
  MaterialColumns materials() const override { return model_->materials(); }
  void io_plant(Archive& a) override {
    a.all(fired_, missed_, gated_, scans_of_layer_);
    if (config.nozzle_faults.any()) a.all(nozzles_[0], nozzles_[1]);
    a.tag(1, "the plant");
    model_->io(a);
  }

 private:
  void pulse(int axis, std::int64_t t_us, const double position_mm[3],
             const double velocity_mm_s[3]) override {
    if (axis == 1) {
      const TruePlace place =
          true_place(config.stage_faults, config.grid, {position_mm[0], position_mm[1]}, velocity_mm_s[0]);
      return scan(t_us, place.x_mm, place.y_mm, position_mm[1]);
    }
    if (axis != 0) return;
    // One line drives both jets; each obeys when it is set to external triggers.
    int droplets_a = 0, droplets_b = 0;
    const ShotOutcome a = jet_->trigger(t_us, droplets_a);
    const ShotOutcome b = config.two_inks ? jet_b_->trigger(t_us, droplets_b) : ShotOutcome::kGatedSource;
    const Stage at{position_mm[0], position_mm[1], velocity_mm_s[0], velocity_mm_s[1]};
    if (a == ShotOutcome::kFired) fire(t_us, at, Material::kA, droplets_a);
    if (b == ShotOutcome::kFired) fire(t_us, at, Material::kB, droplets_b);
    if (a == ShotOutcome::kFired || b == ShotOutcome::kFired) return;
    ++gated_;
    const bool of_b = b != ShotOutcome::kGatedSource;  // why the armed one did not obey
    write_shot(at, shot_of(t_us, at, of_b ? Material::kB : Material::kA), of_b ? b : a, {});
  }

  void softtrigger(std::int64_t t_us, Port port, int droplets) override {
    const Vec3 at = stage_.place->position_mm(t_us);
    const NearestCell below = nearest_cell(config.grid, at[0], at[1]);
    const JetTwin& by = port == Port::kJetB ? *jet_b_ : *jet_;
    if (by.jetting() && !config.grid.contains(below.i, below.j)) return;  // into the camera's tray
    fire(t_us, {at[0], at[1], stage_.place->velocity_mm_s(0, t_us), stage_.place->velocity_mm_s(1, t_us)},
         port == Port::kJetB ? Material::kB : Material::kA, droplets);
  }

  /// Position and speed of the stage, as its encoders say.
  struct Stage {
    double x_mm, y_mm, vx_mm_s, vy_mm_s;
  };
  Shot shot_of(std::int64_t t_us, const Stage& at, Material ink) const {
    const bool b = ink == Material::kB;
    return {t_us,
            at.x_mm + (b ? config.nozzle_b_x_mm : 0.0),
            at.y_mm + (b ? config.nozzle_b_y_mm : 0.0),
            at.vx_mm_s,
            at.vy_mm_s,
            ink};
  }

  void fire(std::int64_t t_us, const Stage& at, Material ink, int droplets) {
    const Shot shot = shot_of(t_us, at, ink);
    const bool b = ink == Material::kB;
    const NozzleShot leaves = nozzles_[b].fire(t_us, int(model_->layers().layer()) + 1, droplets);
    const JetTwin& by = b ? *jet_b_ : *jet_;
    const double share = (b ? config.jet_b : config.jet).volume_by_pulse
                             ? jet_volume_share(config.strobe, by.pulse())
                             : shot.volume_share;
    const int leave = by.nozzle_dead() || share <= 0.0 ? 0 : leaves.droplets;
    const TruePlace place = true_place(config.stage_faults, config.grid, {at.x_mm, at.y_mm}, at.vx_mm_s);
    Shot from = shot;
    from.volume_share = share;
    from.x_mm += place.x_mm - at.x_mm + leaves.dx_mm;
    from.y_mm += place.y_mm - at.y_mm + leaves.dy_mm;
    for (int n = droplets; n < leave; ++n) model_->fire(from);  // dripped, beside those that were triggered
    Landing no_drop;
    no_drop.missed = true;
    for (int n = 0; n < droplets; ++n) {
      const Landing landing = n < leave ? model_->fire(from) : no_drop;
      ++fired_;
      missed_ += landing.missed;
      write_shot(at, shot, landing.missed ? ShotOutcome::kMissed : ShotOutcome::kFired, landing);
    }
  }

  void write_shot(const Stage& at, const Shot& shot, ShotOutcome outcome, const Landing& landing) {
    if (!record) return;
    // The cell below which it lands without scatter.
    const double fall_s = config.droplet.flight_time_s;
    const NearestCell cell = nearest_cell(config.grid, shot.x_mm + fall_s * shot.vx_mm_s, shot.y_mm);
    write(RecordKind::kShot, ShotRecord{shot.t_us,
                                        at.x_mm,
                                        at.y_mm,
                                        landing.x_mm,
                                        landing.y_mm,
                                        landing.volume_mm3,
                                        cell.i,
                                        cell.j,
                                        model_->layers().exposures(),
                                        outcome,
                                        std::uint8_t(shot.ink == Material::kB),
                                        {}});
  }

  // The head hangs over the stage's x; to within a count its place is that of its calibration.
  double head_shift_mm(double stage_x_mm) const {
    constexpr double kPlace_mm = 1e-3;
    const GridSpec& g = config.grid;
    const double shift_mm = stage_x_mm - 0.5 * (g.x_mm(0) + g.x_mm(g.nx - 1));
    return std::abs(shift_mm) < kPlace_mm ? 0.0 : shift_mm;
  }

  /// The head's view with the stage there, into line_. @param number of the measurement of this layer
  void measure(double stage_x_mm, double stage_y_mm, std::uint32_t number) {
    const ProfilerParams& p = config.profiler;
    measure_profile(
        model_->surface(), config.sensor, {config.seed, model_->layers().layer(), number},
        stage_y_mm + p.laser_offset_y_mm + p.error_y_mm,
        profile_x0_mm(config.grid, p) + p.laser_offset_x_mm + p.error_x_mm + head_shift_mm(stage_x_mm),
        profile_dx_mm(config.grid, p), line_);
    if (p.error_z_mm != 0.0)
      for (double& z : line_) z += p.error_z_mm;
  }

  /// Of a person's question between the pulses: its noise is that of the time.
  double look(std::int64_t t_us) {
    constexpr std::uint32_t kBesidePulses = 0x8000'0000u;
    const Vec3 at = stage_.place->position_mm(t_us);
    measure(at[0], at[1], kBesidePulses | std::uint32_t(t_us));
    return line_[0];
  }

  /// @param said_y_mm by the stage's encoder
  void scan(std::int64_t t_us, double stage_x_mm, double stage_y_mm, double said_y_mm) {
    const double y_mm = stage_y_mm + config.profiler.laser_offset_y_mm;
    const bool crossed = stage_.place->encoder_crossed();
    const auto encoder = std::int32_t(stage_.place->encoder_counts(1, crossed ? stage_x_mm : said_y_mm));
    model_->measured();
    measure(stage_x_mm, stage_y_mm, scans_of_layer_++);
    profiler_->trigger(t_us, encoder, line_);
    write(RecordKind::kScanTrigger, ScanRecord{t_us, y_mm, profiler_->triggers(), encoder});
  }

  TakenPicture picture(const Exposure& e) const {
    const bool droplet =
        jet_->jetting() && !jet_->nozzle_dead() && jet_->starts() > std::uint32_t(config.strobe.dead_before);
    return strobe_scene(config, droplet ? jet_speed_m_s(config.strobe, jet_->pulse()) : 0.0, e);
  }

  void lamp(std::int64_t t_us, LampEvent event, double dose_s) override {
    const bool cured = event != LampEvent::kOpened && dose_s >= config.lamp.min_dose_s;
    if (cured) {
      model_->expose(t_us);
      scans_of_layer_ = 0;
    }
    write(RecordKind::kLamp,
          LampRecord{t_us, dose_s, model_->layers().exposures(), event, std::uint8_t(cured), {}});
  }

  void note(std::int64_t t_us, Port port, DeviceEvent event, std::int64_t value) override {
    if (event == DeviceEvent::kJetDisarmed) model_->end_pass();
    write(RecordKind::kDevice, DeviceRecord{t_us, value, port, event, {}});
  }

  void link_closed(std::int64_t t_us, Port port) override { note_closed(t_us, port); }

  std::unique_ptr<Model> model_;
  StageParts stage_;
  std::unique_ptr<JetTwin> jet_;
  std::unique_ptr<ProfileSensor> profiler_;
  LampTwin lamp_twin_;
  std::unique_ptr<JetTwin> jet_b_;
  CameraTwin camera_;
  std::array<NozzleFault, 2> nozzles_;  ///< of jet and jet_b
  std::vector<double> line_;            ///< points of one profile

  std::int64_t fired_ = 0, missed_ = 0, gated_ = 0;
  std::uint32_t scans_of_layer_ = 0;  ///< scan triggers since the last exposure
};

std::unique_ptr<WorldLab> make_inkjet_lab(const WorldConfig& config, WorldRecord* record) {
  return std::make_unique<InkjetLab>(config, record);
}

}  // namespace

const WorldKind kInkjetWorld{"inkjet", kPortNames, &check_inkjet,
                             [](const WorldConfig&) { return std::string(); }, &make_inkjet_lab};

}  // namespace firn::plant
