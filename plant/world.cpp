#include "plant/world.h"

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "logfile/checksum.h"
#include "plant/sensor.h"
#include "plant/twins/jet.h"
#include "plant/twins/lamp.h"
#include "plant/twins/laser_profiler.h"
#include "plant/twins/stage.h"

namespace firn::plant {
namespace {

std::size_t port_of(std::string_view name) {
  for (std::size_t n = 0; n < kPortNames.size(); ++n)
    if (kPortNames[n] == name) return n;
  throw std::invalid_argument("world: unknown port \"" + std::string(name) +
                              "\"; known: stage jet laser_profiler lamp jet_b");
}

// What a saved state must agree with to make sense.
std::string fingerprint(const WorldConfig& c) {
  char text[320];
  const GridSpec& g = c.grid;
  std::snprintf(text, sizeof text, "%s %llu %d %d %a %a %a %a %d %d %d %d", c.model.c_str(),
                static_cast<unsigned long long>(c.seed), g.nx, g.ny, g.pitch_x_mm, g.pitch_y_mm,
                g.origin_x_mm, g.origin_y_mm, c.droplet.fine_cells, c.droplet.margin_cells,
                c.profiler.points, int(c.two_inks));
  return text;
}

}  // namespace

struct World::Impl : Wires {
  Impl(const WorldConfig& c, WorldRecord* r)
      : config(c),
        record(r),
        model(make_model(c)),
        stage(c.stage, *this),
        jet(Port::kJet, c.jet, *this),
        profiler(c.profiler, profile_x0_mm(c.grid, c.profiler), profile_dx_mm(c.grid, c.profiler)),
        lamp_twin(c.lamp, *this),
        jet_b(Port::kJetB, c.jet_b, *this),
        twins{&stage, &jet, &profiler, &lamp_twin, &jet_b},
        line(std::size_t(c.profiler.points)) {}

  // Inner events in order of time; at equal times in the order of the ports.
  void run_until(std::int64_t t_us) {
    for (;;) {
      Twin* first = nullptr;
      std::int64_t at_us = kNever;
      for (Twin* twin : twins)
        if (const std::int64_t next = twin->next_inner_us(); next < at_us) first = twin, at_us = next;
      if (!first || at_us > t_us) break;
      first->step();
    }
    now_us = std::max(now_us, t_us);
  }

  template <class T>
  void write(RecordKind kind, const T& r) {
    if (record) record->append(kind, std::as_bytes(std::span(&r, 1)));
  }

  void begin(bool restored) {
    write(RecordKind::kBegin, BeginRecord{now_us, fired, model->layers().exposures(), restored ? 1u : 0u});
    if (record) record->flush();
  }

  void pulse(int axis, std::int64_t t_us, const double position_mm[3],
             const double velocity_mm_s[3]) override {
    if (axis == 1) return scan(t_us, position_mm[1]);
    if (axis != 0) return;
    // One line drives both jets; each obeys when it is set to external triggers.
    int droplets_a = 0, droplets_b = 0;
    const ShotOutcome a = jet.trigger(t_us, droplets_a);
    const ShotOutcome b = config.two_inks ? jet_b.trigger(t_us, droplets_b) : ShotOutcome::kGatedSource;
    const Stage at{position_mm[0], position_mm[1], velocity_mm_s[0], velocity_mm_s[1]};
    if (a == ShotOutcome::kFired) fire(t_us, at, Material::kA, droplets_a);
    if (b == ShotOutcome::kFired) fire(t_us, at, Material::kB, droplets_b);
    if (a == ShotOutcome::kFired || b == ShotOutcome::kFired) return;
    ++gated;
    const bool of_b = b != ShotOutcome::kGatedSource;  // why the armed one did not obey
    write_shot(at, shot_of(t_us, at, of_b ? Material::kB : Material::kA), of_b ? b : a, {});
  }

  void softtrigger(std::int64_t t_us, Port port, int droplets) override {
    const Vec3 at = stage.device().position_mm(t_us);
    fire(t_us, {at[0], at[1], stage.device().velocity_mm_s(0, t_us), stage.device().velocity_mm_s(1, t_us)},
         port == Port::kJetB ? Material::kB : Material::kA, droplets);
  }

  /// Position and speed of the stage.
  struct Stage {
    double x_mm, y_mm, vx_mm_s, vy_mm_s;
  };
  Shot shot_of(std::int64_t t_us, const Stage& at, Material ink) const {
    const bool b = ink == Material::kB;
    return {t_us, at.x_mm + (b ? config.nozzle_b_x_mm : 0.0), at.y_mm + (b ? config.nozzle_b_y_mm : 0.0),
            at.vx_mm_s, at.vy_mm_s, ink};
  }

  void fire(std::int64_t t_us, const Stage& at, Material ink, int droplets) {
    const Shot shot = shot_of(t_us, at, ink);
    for (int n = 0; n < droplets; ++n) {
      const Landing landing = model->fire(shot);
      ++fired;
      missed += landing.missed;
      write_shot(at, shot, landing.missed ? ShotOutcome::kMissed : ShotOutcome::kFired, landing);
    }
  }

  void write_shot(const Stage& at, const Shot& shot, ShotOutcome outcome, const Landing& landing) {
    if (!record) return;
    const NearestCell cell = nearest_cell(config.grid, shot.x_mm, shot.y_mm);
    write(RecordKind::kShot, ShotRecord{shot.t_us,
                                        at.x_mm,
                                        at.y_mm,
                                        landing.x_mm,
                                        landing.y_mm,
                                        landing.volume_mm3,
                                        cell.i,
                                        cell.j,
                                        model->layers().exposures(),
                                        outcome,
                                        std::uint8_t(shot.ink == Material::kB),
                                        {}});
  }

  void scan(std::int64_t t_us, double stage_y_mm) {
    const double y_mm = stage_y_mm + config.profiler.laser_offset_y_mm;
    const auto encoder = std::int32_t(stage.device().encoder_counts(1, stage_y_mm));
    model->measured();
    measure_profile(model->surface(), config.sensor, {config.seed, model->layers().layer(), scans_of_layer++},
                    y_mm, profile_x0_mm(config.grid, config.profiler),
                    profile_dx_mm(config.grid, config.profiler), line);
    profiler.trigger(t_us, encoder, line);
    write(RecordKind::kScanTrigger, ScanRecord{t_us, y_mm, profiler.triggers(), encoder});
  }

  void lamp(std::int64_t t_us, LampEvent event, double dose_s) override {
    const bool cured = event != LampEvent::kOpened && dose_s >= config.lamp.min_dose_s;
    if (cured) {
      model->expose(t_us);
      scans_of_layer = 0;
    }
    write(RecordKind::kLamp, LampRecord{t_us, dose_s, model->layers().exposures(), event, std::uint8_t(cured), {}});
  }

  void note(std::int64_t t_us, Port port, DeviceEvent event, std::int64_t value) override {
    if (event == DeviceEvent::kJetDisarmed) model->end_pass();
    write(RecordKind::kDevice, DeviceRecord{t_us, value, port, event, {}});
  }

  void link_closed(std::int64_t t_us, Port port) override {
    write(RecordKind::kLink, LinkRecord{t_us, port, 0, 1, {}});
  }

  void drop_link(std::size_t port, std::int64_t t_us) {
    if (!twins[port]->link().connected()) return;
    twins[port]->link().disconnect();
    twins[port]->disconnected(t_us);
    write(RecordKind::kLink, LinkRecord{t_us, Port(port), 0, 0, {}});
  }

  void io(Archive& a) {
    a.tag(0x4e524946, "the head");  // "FIRN"
    std::string print = fingerprint(config);
    a(print);
    if (print != fingerprint(config))
      throw std::runtime_error("world state: of another configuration: \"" + print + "\", not \"" +
                               fingerprint(config) + "\"");
    a.all(now_us, fired, missed, gated, scans_of_layer);
    a.tag(1, "the plant");
    model->io(a);
    for (std::size_t n = 0; n < twins.size(); ++n) {
      a.tag(std::uint32_t(2 + n), kPortNames[n].data());
      twins[n]->io(a);
    }
    a.expect_end();
  }

  WorldConfig config;
  WorldRecord* record;
  std::unique_ptr<Model> model;
  StageTwin stage;
  JetTwin jet;
  ProfilerTwin profiler;
  LampTwin lamp_twin;
  JetTwin jet_b;
  std::array<Twin*, 5> twins;
  std::vector<double> line;  ///< points of one profile

  std::int64_t now_us = 0;
  std::int64_t fired = 0, missed = 0, gated = 0;
  std::uint32_t scans_of_layer = 0;  ///< scan triggers since the last exposure
};

World::World(const WorldConfig& config, WorldRecord* record) : impl_(std::make_unique<Impl>(config, record)) {
  impl_->begin(false);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

void World::connect(std::string_view port, std::int64_t now_us) {
  const std::size_t n = port_of(port);
  impl_->run_until(now_us);
  impl_->drop_link(n, now_us);
  impl_->twins[n]->link().connect(now_us);
  impl_->twins[n]->connected(now_us);
  impl_->write(RecordKind::kLink, LinkRecord{now_us, Port(n), 1, 0, {}});
}

void World::disconnect(std::string_view port, std::int64_t now_us) {
  const std::size_t n = port_of(port);
  impl_->run_until(now_us);
  impl_->drop_link(n, now_us);
}

void World::receive(std::string_view port, std::span<const std::byte> bytes, std::int64_t now_us) {
  const std::size_t n = port_of(port);
  impl_->run_until(now_us);
  Twin& twin = *impl_->twins[n];
  if (!twin.link().connected()) return;
  if (Port(n) == Port::kJet || Port(n) == Port::kJetB || Port(n) == Port::kLamp)
    twin.link().arrive(bytes, impl_->now_us);
  else if (!twin.link().hung())
    twin.take(bytes, impl_->now_us);
}

void World::inject(const SimFault& fault, std::int64_t now_us) {
  const std::size_t n = port_of(fault.port);
  impl_->run_until(now_us);
  Twin& twin = *impl_->twins[n];
  const bool was_connected = twin.link().connected();
  if (fault.kind == FaultKind::kTrip) return twin.trip(now_us, fault.count != 0);
  if (fault.kind == FaultKind::kReboot) {
    twin.reboot(now_us);
    twin.link().close(now_us);
  } else {
    twin.link().inject(fault, now_us);
  }
  if (was_connected && !twin.link().connected()) {
    twin.disconnected(now_us);
    impl_->link_closed(now_us, Port(n));
  }
}

std::int64_t World::next_event_us() const {
  std::int64_t next = kNever;
  for (const Twin* twin : impl_->twins) next = std::min(next, twin->next_visible_us());
  return next;
}

std::int64_t World::next_inner_us() const {
  std::int64_t next = next_event_us();
  for (const Twin* twin : impl_->twins) next = std::min(next, twin->next_inner_us());
  return next;
}

void World::advance(std::int64_t now_us, const SendFn& send) {
  impl_->run_until(now_us);
  for (;;) {
    std::size_t first = 0;
    for (std::size_t n = 1; n < impl_->twins.size(); ++n)
      if (impl_->twins[n]->link().next_send_us() < impl_->twins[first]->link().next_send_us()) first = n;
    TwinLink& link = impl_->twins[first]->link();
    if (link.next_send_us() > now_us || link.next_send_us() == kNever) break;
    const TwinLink::Chunk chunk = link.pop_send();
    send({kPortNames[first], chunk.t_us, std::as_bytes(std::span(chunk.bytes)), chunk.close != 0});
  }
}

Truth World::truth() const {
  const Model& model = *impl_->model;
  return {model.layers().exposures(),  impl_->fired,   impl_->missed,     impl_->gated,
          model.volume_mm3(), model.ledger(), model.cell_means()};
}

MaterialColumns World::materials() const { return impl_->model->materials(); }

std::uint32_t World::exposures() const { return impl_->model->layers().exposures(); }
const WorldConfig& World::config() const { return impl_->config; }

void World::save(const std::filesystem::path& path) const {
  if (impl_->record) impl_->record->flush();
  Archive archive;
  impl_->io(archive);
  std::vector<std::byte> bytes = archive.bytes();
  const std::uint64_t sum = logfile::checksum64(bytes);
  const auto tail = std::as_bytes(std::span(&sum, 1));
  bytes.insert(bytes.end(), tail.begin(), tail.end());

  const std::filesystem::path temporary = path.string() + ".new";
  const auto fail = [&](const char* what) {
    throw std::runtime_error("world state: cannot " + std::string(what) + " " + temporary.string() + ": " +
                             std::strerror(errno));
  };
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) fail("create");
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno != EINTR) {
      ::close(fd);
      fail("write");
    }
    if (n > 0) done += std::size_t(n);
  }
  if (::fsync(fd) != 0) {
    ::close(fd);
    fail("sync");
  }
  ::close(fd);
  std::filesystem::rename(temporary, path);
}

World World::restore(const std::filesystem::path& path, const WorldConfig& config, WorldRecord* record) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("world state: cannot open " + path.string());
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto all = std::as_bytes(std::span(text));
  std::uint64_t sum = 0;
  if (all.size() < sizeof sum) throw std::runtime_error("world state: " + path.string() + " is cut short");
  std::memcpy(&sum, all.data() + all.size() - sizeof sum, sizeof sum);
  const auto body = all.first(all.size() - sizeof sum);
  if (logfile::checksum64(body) != sum)
    throw std::runtime_error("world state: " + path.string() + " is damaged (checksum)");
  World world(config, nullptr);
  Archive archive(std::vector<std::byte>(body.begin(), body.end()));
  world.impl_->io(archive);
  world.impl_->record = record;
  world.impl_->begin(true);
  for (std::size_t n = 0; n < kPortNames.size(); ++n) world.impl_->drop_link(n, world.impl_->now_us);
  return world;
}

}  // namespace firn::plant
