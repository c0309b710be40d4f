// Any bytes as a picture and its background: droplets with finite places inside it, of finite size.
#include <cmath>

#include "core/vision/sweep.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;
using namespace firn::vision;

namespace {

constexpr std::uint16_t kWhite[] = {255, 1023, 4095, 65535};

void check(const Droplet& d, const Frame& f) {
  require(std::isfinite(d.x) && std::isfinite(d.y) && std::isfinite(d.diameter_px) && d.diameter_px > 0,
          "a droplet is finite");
  require(d.x_std >= 0 && d.y_std >= 0 && d.diameter_std_px >= 0, "deviations are finite");
  require(d.x > -f.width && d.x < 2 * f.width && d.y > -f.height && d.y < 2 * f.height,
          "a droplet lies near the picture");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 20) return 0;
  Frame f{kMinSide + data[0] % 32, kMinSide + data[1] % 32, kWhite[data[2] % 4], {}};
  // Runs of one level: objects rather than noise.
  const std::size_t repeat = 1 + data[3] % 24;
  for (std::size_t i = 0; i < std::size_t(f.width) * std::size_t(f.height); ++i)
    f.pixels.push_back(std::uint16_t(data[4 + (i / repeat) % (size - 4)] * (f.white / 255)));
  Frame other = f;
  for (std::size_t i = 0; i < other.pixels.size(); i += 3)
    other.pixels[i] = std::uint16_t(f.white - f.pixels[i]);
  const Background background = known_background(other, Polarity::kAuto);
  std::vector<TimedPicture> timed;
  for (const Background* b : {static_cast<const Background*>(nullptr), &background}) {
    const DropletPicture p = find_droplets(f, b);
    if (p.state != PictureState::kNoDrop) check(p.main, f);
    for (const Droplet& d : p.drops) check(d, f);
    for (const Droplet& d : p.satellites) check(d, f);
    timed.push_back({double(timed.size()), p});
  }
  timed.push_back({double(data[1]), timed.front().picture});
  const SweepResult r = measure_sweep(timed, {1.0, 0.01});
  for (const Estimate& e :
       {r.velocity_m_s, r.angle_deg, r.diameter_um, r.volume_pl, r.break_off_us, r.jitter_us})
    require(!e.known || (std::isfinite(e.value) && std::isfinite(e.std)), "an estimate is finite");
  return 0;
}
