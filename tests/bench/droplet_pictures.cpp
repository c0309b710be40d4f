// Measures the vision core on rendered strobe sweeps, drawn at random, and one large picture.
//   droplet_pictures [SWEEPS=500 [SEED=90000]]; 0 sweeps: the large picture alone
// The thresholds of core/vision were set on seeds below 50000.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <vector>

#include "core/vision/sweep.h"
#include "plant/inkjet/strobe_picture.h"
#include "tests/bench/bench.h"
#include "tests/bench/drawn_light.h"

namespace firn::bench::droplet_pictures {

using namespace firn;
using namespace firn::plant;
using namespace firn::vision;

namespace {

constexpr LightRange kLight{1.5, 0.9, 0.02, 12};

struct Drawn {
  StrobeCamera camera;
  StrobeJet jet;
  std::vector<double> delays_us;
};

Drawn draw(std::uint64_t seed) {
  RandomStream r(seed, Purpose::kTest);
  Drawn d;
  StrobeCamera& c = d.camera;
  StrobeJet& j = d.jet;
  c.width = 400;
  c.height = 320;
  j.diameter_um = r.uniform(25, 75);
  c.um_per_px = j.diameter_um / r.uniform(14, 45);
  draw_light(r, kLight, c);
  c.opacity = r.uniform(0.65, 0.97);
  if (r.uniform() < 0.6) {
    c.spot = r.uniform(0.3, 1.0);
    c.spot_radius = r.uniform(0.15, 0.4);
  }
  draw_noise(r, c);
  c.nozzle_um = r.uniform(50, 180) * c.um_per_px;
  c.nozzle_x_px = r.uniform(160, 240);
  c.nozzle_y_px = r.uniform(15, 50);
  c.nozzle_taper = r.uniform() < 0.5 ? 0.0 : r.uniform(0, 0.4);
  c.bright_objects = r.uniform() < 0.15;
  draw_dirt(r, kLight, c);
  j.speed_m_s = r.uniform(1, 6);
  j.angle_deg = r.uniform(-5, 5);
  j.ligament_um = std::max(2.5 * c.um_per_px, 0.15 * j.diameter_um);
  j.stretch = r.uniform(0, 0.1);
  j.jitter_us = r.uniform() < 0.5 ? 0.0 : r.uniform(0, 0.5) * c.um_per_px / j.speed_m_s;
  const double us_per_px = c.um_per_px / j.speed_m_s, radius = 0.5 * j.diameter_um / c.um_per_px;
  j.break_off_us = (2 * radius + r.uniform(15, 45)) * us_per_px;
  j.recoil_us = r.uniform(5, 20) * us_per_px;
  for (std::uint32_t k = r.below(3); k > 0; --k)
    j.satellites.push_back({std::max(3.05 * c.um_per_px, r.uniform(0.1, 0.5) * j.diameter_um),
                            r.uniform(0.85, 1.0), r.uniform(0.2, 0.6)});
  const double last = (c.height - c.nozzle_y_px - radius - 6) * us_per_px *
                      (j.speed_m_s / fly(j.speed_m_s, j.diameter_um, 250 * us_per_px).speed_m_s);
  const int n = 8 + int(r.below(9));
  const double first = j.break_off_us * r.uniform(0.3, 0.9);
  for (int k = 0; k < n; ++k) d.delays_us.push_back(first + (last - first) * k / (n - 1));
  return d;
}

Frame frame_of(StrobePicture&& p) { return {p.width, p.height, p.white, std::move(p.pixels)}; }

struct Score {
  std::vector<double> error;  // in the unit of the limit
  int n = 0, covered = 0, within = 0;
  void add(double off, double std, double limit) {
    ++n;
    covered += std::abs(off) <= 1.96 * std;
    within += std::abs(off) <= limit;
    error.push_back(std::abs(off) / limit);
  }
  void print(const char* name, const char* limit) {
    if (n == 0) return;
    std::sort(error.begin(), error.end());
    double square = 0;
    for (const double e : error) square += e * e;
    std::printf(
        "%-22s n %4d  within %s: %5.1f %%  rms %.3f  99th %.3f  worst %.3f of it  95 %% intervals cover %.1f "
        "%%\n",
        name, n, limit, 100.0 * within / n, std::sqrt(square / n), error[error.size() * 99 / 100],
        error.back(), 100.0 * covered / n);
  }
};

double cpu_ms() { return 1e3 * double(std::clock()) / CLOCKS_PER_SEC; }

void measure_empty(int n, std::uint64_t seed) {
  int alone = 0, with_background = 0;
  for (int k = 0; k < n; ++k) {
    Drawn d = draw(seed + std::uint64_t(k));
    std::vector<Frame> frames;
    for (int i = 0; i < 6; ++i)
      frames.push_back(
          frame_of(render_strobe(d.camera, nullptr, 0, seed + std::uint64_t(k), std::uint32_t(i))));
    std::vector<const Frame*> some;
    for (int i = 0; i < 5; ++i) some.push_back(&frames[std::size_t(i)]);
    const auto background = find_background(some, true);
    alone += find_droplets(frames[5], nullptr).state != PictureState::kNoDrop;
    with_background +=
        find_droplets(frames[5], background ? &*background : nullptr).state != PictureState::kNoDrop;
  }
  std::printf(
      "empty pictures         n %4d  false droplets: %d with the background of the camera, %d from one "
      "picture alone (round dark dirt)\n",
      n, with_background, alone);
}

void measure_cpu() {
  StrobeCamera c;
  c.width = 2048;
  c.height = 1536;
  c.um_per_px = 0.8;
  c.nozzle_x_px = 1000;
  c.nozzle_y_px = 300;
  c.spot = 0.8;
  c.blur_px = 1.6;
  StrobeJet j;
  j.satellites = {{12, 0.9, 0.5}};
  const Frame frame = frame_of(render_strobe(c, &j, 120, 1, 0));
  std::vector<double> ms;
  for (int k = 0; k < 21; ++k) {
    const double begin = cpu_ms();
    find_droplets(frame, nullptr);
    ms.push_back(cpu_ms() - begin);
  }
  std::sort(ms.begin(), ms.end());
  std::printf("2048 x 1536 picture: %.1f ms CPU (median of 21; %.1f to %.1f)\n", ms[10], ms.front(),
              ms.back());
}

}  // namespace

FIRN_BENCH(droplet_pictures) {
  std::uint64_t numbers[2] = {500, 90000};
  for (int k = 1; k < argc; ++k) {
    const std::string_view text = argv[k];
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), numbers[std::min(k, 2) - 1]);
    if (k > 2 || error != std::errc{} || end != text.data() + text.size() || numbers[0] > 1'000'000) {
      std::fprintf(stderr, "usage: droplet_pictures [SWEEPS [SEED]], SWEEPS at most 1000000\n");
      return text == "--help" ? 0 : 2;
    }
  }
  const int n = int(numbers[0]);
  const std::uint64_t seed = numbers[1];
  if (n == 0) {
    measure_cpu();
    return 0;
  }
  Score velocity, diameter, angle, nozzle, break_off, centroid, single;
  int satellites = 0, satellites_found = 0, wrong_state = 0, pictures = 0, failed = 0, no_background = 0;
  for (int k = 0; k < n; ++k) {
    const Drawn d = draw(seed + std::uint64_t(k));
    std::vector<Frame> frames;
    std::vector<StrobeTruth> truth;
    for (std::size_t i = 0; i < d.delays_us.size(); ++i) {
      StrobePicture p =
          render_strobe(d.camera, &d.jet, d.delays_us[i], seed + std::uint64_t(k), std::uint32_t(i));
      truth.push_back(p.truth);
      frames.push_back(frame_of(std::move(p)));
    }
    std::vector<const Frame*> pointers;
    for (const Frame& f : frames) pointers.push_back(&f);
    const auto background = find_background(pointers, true);
    no_background += !background;
    std::vector<TimedPicture> timed;
    std::vector<DropletPicture> found;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      found.push_back(find_droplets(frames[i], background ? &*background : nullptr));
      timed.push_back({d.delays_us[i], found.back()});
      const DropletPicture& p = found.back();
      const StrobeTruth& t = truth[i];
      if (!t.inside) continue;
      ++pictures;
      const PictureState wanted = t.broken_off ? PictureState::kDrop : PictureState::kNotBrokenOff;
      wrong_state += p.state != wanted;
      if (p.state != wanted && std::getenv("VERBOSE"))
        std::printf("  sweep %d picture %zu: state %d, wanted %d; tail %.1f px, d %.1f, flown %.1f\n", k, i,
                    int(p.state), int(wanted), t.tail_px, t.diameter_px, t.y_px - d.camera.nozzle_y_px);
      if (p.state == PictureState::kNoDrop) continue;
      single.add(p.main.diameter_px / t.diameter_px - 1, p.main.diameter_std_px / t.diameter_px, 0.03);
      centroid.add(p.main.x - t.x_px, p.main.x_std, 3.0);
      centroid.add(p.main.y - t.y_px, p.main.y_std, 3.0);
      for (const StrobeTruth::Spot& s : t.satellites) {
        if (!s.inside || !s.apart || s.diameter_px < 3) continue;
        ++satellites;
        bool seen = false;
        for (const auto* list : {&p.satellites, &p.drops})
          for (const Droplet& o : *list)
            seen = seen || std::hypot(o.x - s.x_px, o.y - s.y_px) < 0.5 * s.diameter_px + 1;
        satellites_found += seen;
        if (!seen && std::getenv("VERBOSE"))
          std::printf("  sweep %d picture %zu: satellite of %.1f px at %.0f %.0f missed, blur %.2f\n", k, i,
                      s.diameter_px, s.x_px, s.y_px, d.camera.blur_px);
      }
    }
    const Scale scale{d.camera.um_per_px, 0.0};
    const SweepResult r = measure_sweep(timed, scale);
    if (!r.velocity_m_s.known) {
      ++failed;
      continue;
    }
    // The line's slope is the mean velocity of the droplets that were seen; the truth is that of the flown
    // distances.
    const double speed = fly(d.jet.speed_m_s, d.jet.diameter_um, r.middle_us).speed_m_s;
    velocity.add(r.velocity_m_s.value / speed - 1, r.velocity_m_s.std / speed, 0.02);
    diameter.add(r.diameter_um.value / d.jet.diameter_um - 1, r.diameter_um.std / d.jet.diameter_um, 0.02);
    angle.add(r.angle_deg.value - d.jet.angle_deg, r.angle_deg.std, 0.3);
    if (r.break_off_us.known)
      break_off.add(r.break_off_us.value / d.jet.break_off_us - 1, r.break_off_us.std / d.jet.break_off_us,
                    0.2);
    const Scale own = scale_from_nozzle(found, d.camera.nozzle_um);
    if (d.camera.nozzle_taper == 0 && own.um_per_px > 0 && std::getenv("VERBOSE") &&
        std::abs(own.um_per_px / d.camera.um_per_px - 1) > 0.004)
      std::printf(
          "  sweep %d: nozzle %.2f px of %.2f, edge %.2f of %.2f, bright %d light %.2f flicker %.3f\n", k,
          found[0].nozzle.width_px, d.camera.nozzle_um / d.camera.um_per_px, found[0].nozzle.edge.y,
          d.camera.nozzle_y_px, d.camera.bright_objects, d.camera.light, d.camera.flicker);
    if (d.camera.nozzle_taper == 0 && own.um_per_px > 0)
      nozzle.add(own.um_per_px / d.camera.um_per_px - 1, own.std / d.camera.um_per_px, 0.01);
    if (std::getenv("VERBOSE") && (std::abs(r.velocity_m_s.value / speed - 1) > 0.02 ||
                                   std::abs(r.diameter_um.value / d.jet.diameter_um - 1) > 0.02))
      std::printf(
          "  sweep %d: v %+.2f %%, d %+.2f %% (std %.2f), used %d of %d, d %.1f px, blur %.2f, spot %.2f x "
          "%.2f, light %.2f, opacity %.2f, bright %d, noise %.4f %.4f\n",
          k, 100 * (r.velocity_m_s.value / speed - 1), 100 * (r.diameter_um.value / d.jet.diameter_um - 1),
          100 * r.diameter_um.std / d.jet.diameter_um, r.used, r.pictures,
          d.jet.diameter_um / d.camera.um_per_px, d.camera.blur_px, d.camera.spot, d.camera.spot_radius,
          d.camera.light, d.camera.opacity, d.camera.bright_objects, d.camera.read_noise,
          d.camera.shot_noise);
  }
  std::printf("%d sweeps of %d pictures, %d without velocity, %d without background\n", n, pictures, failed,
              no_background);
  velocity.print("velocity", "2 %");
  diameter.print("diameter", "2 %");
  angle.print("angle", "0.3 deg");
  break_off.print("break-off", "20 %");
  nozzle.print("scale by the nozzle", "1 %");
  single.print("one picture: diameter", "3 %");
  centroid.print("one picture: centroid", "3 px");
  std::printf("satellites of 3 px and more, 4 px apart: %d of %d found, %.2f %%; states wrong: %d of %d\n",
              satellites_found, satellites, 100.0 * satellites_found / std::max(1, satellites), wrong_state,
              pictures);
  measure_empty(200 * n / 500, seed + 1000000);
  measure_cpu();
  return 0;
}

}  // namespace firn::bench::droplet_pictures
