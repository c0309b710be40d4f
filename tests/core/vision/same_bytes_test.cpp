// The vision core keeps no state: equal pixels give equal bytes, whoever asks and however often.
#include <bit>
#include <catch2/catch.hpp>
#include <thread>

#include "core/vision/sweep.h"
#include "plant/inkjet/strobe_picture.h"

using namespace firn;
using namespace firn::plant;
using namespace firn::vision;

namespace {

using Bits = std::vector<std::uint64_t>;

void add(Bits& bits, std::initializer_list<double> values) {
  for (const double v : values) bits.push_back(std::bit_cast<std::uint64_t>(v));
}

void add(Bits& bits, const Droplet& d) {
  add(bits, {d.x, d.y, d.x_std, d.y_std, d.diameter_px, d.diameter_std_px, d.axis_ratio, d.tail_px, d.opacity,
             double(d.joined)});
}

void add(Bits& bits, const DropletPicture& p) {
  add(bits, {double(p.state), double(p.cut_off), double(p.bright), p.noise, p.blur_px, p.nozzle.edge.x,
             p.nozzle.edge.y, p.nozzle.edge_std_px, p.nozzle.width_px, p.nozzle.width_std_px});
  add(bits, p.main);
  for (const auto* list : {&p.drops, &p.satellites}) {
    bits.push_back(list->size());
    for (const Droplet& d : *list) add(bits, d);
  }
}

Bits measured(const std::vector<Frame>& frames) {
  Bits bits;
  std::vector<const Frame*> pointers;
  for (const Frame& f : frames) pointers.push_back(&f);
  const auto background = find_background(pointers, true);
  bits.push_back(background.has_value());
  if (background) bits.insert(bits.end(), background->frame.pixels.begin(), background->frame.pixels.end());
  std::vector<TimedPicture> timed;
  for (const Frame& f : frames) {
    add(bits, find_droplets(f, nullptr));
    timed.push_back(
        {40.0 + 14 * double(timed.size()), find_droplets(f, background ? &*background : nullptr)});
    add(bits, timed.back().picture);
  }
  const SweepResult r = measure_sweep(timed, scale_from_nozzle(std::vector{timed[0].picture}, 200));
  for (const Estimate& e : {r.velocity_m_s, r.angle_deg, r.diameter_um, r.volume_pl, r.satellites,
                            r.largest_satellite_um, r.break_off_us, r.jitter_us})
    add(bits, {e.value, e.std, double(e.known)});
  return bits;
}

}  // namespace

TEST_CASE("A sweep gives the same bytes on repeated calls and in several threads at once") {
  StrobeCamera camera;
  camera.width = 280;
  camera.height = 260;
  camera.nozzle_x_px = 140;
  camera.nozzle_y_px = 36;
  camera.spot = 0.8;
  camera.dirt = {{60, 200, 5, 0.4, 1}};
  StrobeJet jet;
  jet.angle_deg = 2;
  jet.jitter_us = 0.3;
  jet.satellites = {{14, 0.9, 0.4}};
  std::vector<std::vector<Frame>> sweeps(2);
  for (std::uint64_t seed = 0; seed < sweeps.size(); ++seed)
    for (std::uint32_t k = 0; k < 8; ++k) {
      StrobePicture p = render_strobe(camera, &jet, 40.0 + 14 * k, seed, k);
      sweeps[seed].push_back({p.width, p.height, p.white, std::move(p.pixels)});
    }
  std::vector<Bits> wanted;
  for (const auto& frames : sweeps) wanted.push_back(measured(frames));
  REQUIRE(wanted[0] != wanted[1]);
  CHECK(measured(sweeps[0]) == wanted[0]);  // after another sweep
  std::vector<Bits> got(6);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < got.size(); ++i)
    threads.emplace_back([&, i] { got[i] = measured(sweeps[i % 2]); });
  for (std::thread& t : threads) t.join();
  for (std::size_t i = 0; i < got.size(); ++i) CHECK(got[i] == wanted[i % 2]);
}
