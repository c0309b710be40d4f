// Droplets of one picture. The pictures come from plant/inkjet/strobe_picture, which shares no code with the
// detector.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "core/vision/droplets.h"
#include "plant/inkjet/strobe_picture.h"

using namespace firn;
using namespace firn::plant;
using namespace firn::vision;

namespace {

Frame frame_of(const StrobePicture& p) { return {p.width, p.height, p.white, p.pixels}; }

StrobeCamera camera() {
  StrobeCamera c;
  c.width = 320;
  c.height = 300;
  c.nozzle_x_px = 150;
  c.nozzle_y_px = 40;
  c.um_per_px = 2.0;
  return c;
}

Frame transposed(const Frame& f) {
  Frame t{f.height, f.width, f.white, std::vector<std::uint16_t>(f.pixels.size())};
  for (int y = 0; y < f.height; ++y)
    for (int x = 0; x < f.width; ++x) t.pixels[t.index(y, x)] = f.at(x, y);
  return t;
}

// A picture of ellipses and boxes, sampled 8 x 8 in each pixel, without blur or noise.
struct Drawing {
  int width = 240, height = 240;
  double ground = 180, dark = 30;
  struct Disc {
    double x, y, r;
    bool bright = false;
  };
  std::vector<Disc> discs;
  struct Box {
    double x0, y0, x1, y1;
  };
  std::vector<Box> boxes;

  Frame frame() const {
    Frame f{width, height, 255, {}};
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        int inside = 0;
        for (int k = 0; k < 64; ++k) {
          const double px = x - 0.5 + (k % 8 + 0.5) / 8, py = y - 0.5 + (k / 8 + 0.5) / 8;
          bool in = false;
          for (const Box& b : boxes) in = in || (px >= b.x0 && px <= b.x1 && py >= b.y0 && py <= b.y1);
          for (const Disc& d : discs)
            if ((px - d.x) * (px - d.x) + (py - d.y) * (py - d.y) <= d.r * d.r) in = !d.bright;
          inside += in;
        }
        f.pixels.push_back(std::uint16_t(ground + (dark - ground) * inside / 64.0 + 0.5));
      }
    return f;
  }
};

}  // namespace

TEST_CASE(
    "A droplet with a bright spot is measured within its stated deviations at any place between pixels") {
  int covered = 0, n = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RandomStream r(seed, Purpose::kTest);
    StrobeCamera c = camera();
    c.spot = r.uniform(0.3, 1);
    c.blur_px = r.uniform(0.7, 1.4);
    c.slope_x = r.uniform(-0.3, 0.3);
    c.vignette = r.uniform(0, 0.3);
    StrobeJet jet;
    jet.diameter_um = r.uniform(36, 80);
    jet.angle_deg = r.uniform(-5, 5);
    const StrobePicture p = render_strobe(c, &jet, r.uniform(90, 140), seed, 0);
    const DropletPicture found = find_droplets(frame_of(p), nullptr);
    CAPTURE(seed);
    REQUIRE(found.state == PictureState::kDrop);
    CHECK(found.main.x == Approx(p.truth.x_px).margin(0.15));
    CHECK(found.main.y == Approx(p.truth.y_px).margin(0.15));
    CHECK(found.main.diameter_px == Approx(p.truth.diameter_px).epsilon(0.02));
    CHECK(found.satellites.empty());
    covered += std::abs(found.main.diameter_px - p.truth.diameter_px) < 1.96 * found.main.diameter_std_px;
    ++n;
  }
  CHECK(covered >= 0.85 * n);
}

TEST_CASE("A transposed picture gives transposed droplets: no direction of flight is built in") {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    RandomStream r(seed, Purpose::kTest, 1);
    StrobeCamera c = camera();
    c.spot = 0.7;
    StrobeJet jet;
    jet.satellites = {{14, 0.9, 0.5}};
    const Frame f = frame_of(render_strobe(c, &jet, r.uniform(20, 140), seed, 0));
    const DropletPicture a = find_droplets(f, nullptr), b = find_droplets(transposed(f), nullptr);
    CAPTURE(seed);
    REQUIRE(a.state == b.state);
    CHECK(a.main.x == Approx(b.main.y).margin(0.03));
    CHECK(a.main.y == Approx(b.main.x).margin(0.03));
    CHECK(a.main.diameter_px == Approx(b.main.diameter_px).epsilon(0.003));
    CHECK(a.satellites.size() == b.satellites.size());
    REQUIRE(a.nozzle.found);
    REQUIRE(b.nozzle.found);
    CHECK(a.nozzle.width_px == Approx(b.nozzle.width_px).margin(0.05));
    CHECK(b.nozzle.flight.x == Approx(1.0));
  }
}

TEST_CASE("A droplet is not broken off while a ligament joins it, and is drop afterwards") {
  StrobeJet jet;
  for (const double delay : {30.0, 40.0, 50.0, 59.0, 61.0, 65.0, 70.0, 90.0}) {
    const StrobePicture p = render_strobe(camera(), &jet, delay, 5, 0);
    const DropletPicture found = find_droplets(frame_of(p), nullptr);
    CAPTURE(delay);
    REQUIRE(found.state == (delay < jet.break_off_us ? PictureState::kNotBrokenOff : PictureState::kDrop));
    CHECK(found.main.diameter_px == Approx(p.truth.diameter_px).epsilon(0.03));
    CHECK(std::hypot(found.main.x - p.truth.x_px, found.main.y - p.truth.y_px) < 0.5);
    if (delay < 60)
      CHECK(found.main.tail_px == Approx(p.truth.y_px - 40 - 0.5 * p.truth.diameter_px).margin(2));
    if (delay > 75) CHECK(found.main.tail_px == 0.0);
  }
}

TEST_CASE("Nothing, a nozzle alone and a droplet that leaves the picture are no drop") {
  Drawing d;
  CHECK(find_droplets(d.frame(), nullptr).state == PictureState::kNoDrop);
  d.boxes = {{80, -1, 160, 50}};
  const DropletPicture nozzle = find_droplets(d.frame(), nullptr);
  CHECK(nozzle.state == PictureState::kNoDrop);
  REQUIRE(nozzle.nozzle.found);
  CHECK(nozzle.nozzle.edge.y == Approx(50).margin(0.1));
  CHECK(nozzle.nozzle.width_px == Approx(80).margin(0.15));
  CHECK(std::abs(nozzle.nozzle.width_px - 80) < 1.96 * nozzle.nozzle.width_std_px);
  d.discs = {{120, 236, 20}};
  const DropletPicture cut = find_droplets(d.frame(), nullptr);
  CHECK(cut.state == PictureState::kNoDrop);
  CHECK(cut.cut_off >= 1);
}

TEST_CASE("Droplets that touch are told apart, and the largest is the main one") {
  Drawing d;
  d.discs = {{100, 100, 30}, {100, 100, 7, true}, {100, 150, 22}, {100, 150, 5, true}};
  const DropletPicture p = find_droplets(d.frame(), nullptr);
  REQUIRE(p.state == PictureState::kDrop);
  CHECK(p.main.y == Approx(100).margin(0.5));
  CHECK(p.main.diameter_px == Approx(60).epsilon(0.02));
  const std::size_t others = p.drops.size() + p.satellites.size();
  REQUIRE(others == 1);
  const Droplet& other = p.drops.empty() ? p.satellites.front() : p.drops.front();
  CHECK(other.y == Approx(150).margin(0.5));
  CHECK(other.diameter_px == Approx(44).epsilon(0.03));
}

TEST_CASE("A droplet on a needle narrower than itself is not broken off, and measured without the needle") {
  Drawing d;
  d.boxes = {{112, -1, 128, 100}};
  d.discs = {{120, 115, 28}};
  const DropletPicture p = find_droplets(d.frame(), nullptr);
  REQUIRE(p.state == PictureState::kNotBrokenOff);
  CHECK(p.main.diameter_px == Approx(56).epsilon(0.03));
  CHECK(std::hypot(p.main.x - 120, p.main.y - 115) < 1.0);
}

TEST_CASE("Bright droplets before a dark ground are found as dark ones before a bright ground") {
  Drawing d;
  d.ground = 25;
  d.dark = 210;
  d.discs = {{90, 130, 21}};
  const DropletPicture p = find_droplets(d.frame(), nullptr);
  CHECK(p.bright);
  REQUIRE(p.state == PictureState::kDrop);
  CHECK(p.main.diameter_px == Approx(42).epsilon(0.01));
  CHECK(p.main.x == Approx(90).margin(0.05));
  DropletOptions dark;
  dark.polarity = Polarity::kDark;
  CHECK(find_droplets(d.frame(), nullptr, dark).state == PictureState::kNoDrop);
}

TEST_CASE("Twelve bits give the same droplet as eight, only better known") {
  StrobeCamera c = camera();
  StrobeJet jet;
  const StrobePicture eight = render_strobe(c, &jet, 100, 3, 0);
  c.white = 4095;
  const StrobePicture twelve = render_strobe(c, &jet, 100, 3, 0);
  const DropletPicture a = find_droplets(frame_of(eight), nullptr),
                       b = find_droplets(frame_of(twelve), nullptr);
  CHECK(a.main.diameter_px == Approx(b.main.diameter_px).epsilon(0.003));
  CHECK(a.main.y == Approx(b.main.y).margin(0.03));
}

TEST_CASE("Dark round dirt is a droplet in one picture, and none beside the others of its sweep") {
  StrobeCamera c = camera();
  c.dirt = {{250, 200, 16, 0.8, 0.8}, {60, 90, 4, 0.6, 0.8}};
  StrobeJet jet;
  jet.speed_m_s = 3;
  std::vector<Frame> frames;
  std::vector<StrobeTruth> truth;
  for (int k = 0; k < 9; ++k) {
    const StrobePicture p = render_strobe(c, &jet, 65 + 10 * k, 8, std::uint32_t(k));
    frames.push_back(frame_of(p));
    truth.push_back(p.truth);
  }
  CHECK(find_droplets(frames[0], nullptr).main.x == Approx(250).margin(1));
  std::vector<const Frame*> pointers;
  for (const Frame& f : frames) pointers.push_back(&f);
  const auto background = find_background(pointers, true);
  REQUIRE(background);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!truth[k].inside) continue;
    const DropletPicture p = find_droplets(frames[k], &*background);
    REQUIRE(p.state == PictureState::kDrop);
    CHECK(p.main.y == Approx(truth[k].y_px).margin(0.15));
    CHECK(p.satellites.empty());
    CHECK(p.drops.empty());
    CHECK(p.nozzle.found);
  }
}

TEST_CASE("Pictures of one delay or of different scenes give no background") {
  StrobeJet jet;
  std::vector<Frame> frames;
  for (int k = 0; k < 6; ++k)
    frames.push_back(frame_of(render_strobe(camera(), &jet, 100, 4, std::uint32_t(k))));
  std::vector<const Frame*> pointers;
  for (const Frame& f : frames) pointers.push_back(&f);
  CHECK_FALSE(find_background(pointers, false));
  CHECK_FALSE(find_background(std::span(pointers).first(4), true));
  // A sweep so fine that the droplet never leaves its own shadow.
  frames.clear();
  for (int k = 0; k < 6; ++k)
    frames.push_back(frame_of(render_strobe(camera(), &jet, 100 + 2 * k, 4, std::uint32_t(k))));
  CHECK_FALSE(find_background(pointers, true));
  frames[2].width = 300;
  frames[2].pixels.resize(300 * 300);
  CHECK_FALSE(find_background(pointers, true));
}

TEST_CASE("Any pixels are a picture: noise, stripes and constant levels end without a crash") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    RandomStream r(seed, Purpose::kTest, 2);
    Frame f{16 + int(r.below(60)), 16 + int(r.below(60)), r.below(2) ? 255 : 65535, {}};
    const std::uint32_t kind = r.below(5);
    for (int y = 0; y < f.height; ++y)
      for (int x = 0; x < f.width; ++x) {
        const double v = kind == 0   ? r.uniform()
                         : kind == 1 ? (x / 3 + y / 5) % 2
                         : kind == 2 ? 1.0
                         : kind == 3 ? 0.0
                                     : double(x) / f.width;
        f.pixels.push_back(std::uint16_t(v * f.white));
      }
    REQUIRE(is_valid(f));
    const DropletPicture p = find_droplets(f, nullptr);
    CHECK(std::isfinite(p.main.x + p.main.diameter_px + p.noise));
  }
}

TEST_CASE("No pixels, one pixel, all black, all white and a size that is only claimed are no drop") {
  const auto even = [](int width, int height, int level) {
    return Frame{width, height, 255,
                 std::vector<std::uint16_t>(std::size_t(width) * std::size_t(height), std::uint16_t(level))};
  };
  const std::vector<Frame> frames{{},
                                  even(1, 1, 7),
                                  even(64, 48, 0),
                                  even(64, 48, 255),
                                  {20000, 20000, 255, {1, 2, 3}},
                                  {16384, 16384, 255, {}},
                                  {-16, -16, 255, std::vector<std::uint16_t>(256)},
                                  {16, 16, 0, std::vector<std::uint16_t>(256)}};
  for (const Frame& f : frames)
    for (const Polarity polarity : {Polarity::kAuto, Polarity::kDark, Polarity::kBright}) {
      CAPTURE(f.width, f.height, int(polarity));
      CHECK(find_droplets(f, nullptr, {polarity}).state == PictureState::kNoDrop);
      const std::vector<const Frame*> five(5, &f);
      const auto still = find_background(five, true, {polarity});
      CHECK((still.has_value() ? is_valid(f) : true));
      const Background known = known_background(f, polarity);
      CHECK(known.frame.pixels.size() == (is_valid(f) ? f.pixels.size() : 0));
      CHECK(known.frame.pixels.size() == known.nozzle.size());
      if (is_valid(f)) CHECK(find_droplets(f, &known, {polarity}).state == PictureState::kNoDrop);
    }
}

TEST_CASE("A dark spot beside a glare is not placed outside of itself") {
  Frame f{96, 96, 255, std::vector<std::uint16_t>(96 * 96, 120)};
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x)
      if ((x - 70) * (x - 70) + (y - 70) * (y - 70) < 100) f.pixels[f.index(x, y)] = 30;
  for (int y = 40; y <= 42; ++y)
    for (int x = 40; x <= 42; ++x) f.pixels[f.index(x, y)] = 30;
  for (int y = 39; y <= 42; ++y) f.pixels[f.index(45, y)] = 240;
  const DropletPicture p = find_droplets(f, nullptr, {Polarity::kDark});
  REQUIRE(p.state == PictureState::kDrop);
  for (const Droplet& d : p.satellites) {
    CHECK(std::abs(d.x - 41) < 4);
    CHECK(std::abs(d.y - 41) < 4);
  }
}

TEST_CASE("Dirt at the picture's edge is no droplet in an empty picture, beside a nozzle or without one") {
  StrobeCamera c = camera();
  c.nozzle_um = GENERATE(0.0, 300.0);
  c.dirt = {{318.0, 150.0, 5.5, 0.5, 2.0}, {90.0, 5.0, 4.7, 0.5, 1.9}};
  std::vector<Frame> frames;
  for (std::uint32_t k = 0; k < 6; ++k) frames.push_back(frame_of(render_strobe(c, nullptr, 0, 3, k)));
  std::vector<const Frame*> scene;
  for (const Frame& f : frames) scene.push_back(&f);
  const auto background = find_background(std::span(scene).first(5), true);
  REQUIRE(background);
  CHECK(find_droplets(frames[5], &*background).state == PictureState::kNoDrop);
}

TEST_CASE("Dirt that noise makes a droplet in some of the empty pictures belongs to their background",
          "[seeded]") {
  StrobeCamera c = camera();
  c.light = 0.88;
  c.dirt = {{127, 154, 4.1, 0.43, 2.9}, {86, 141, 4.4, 0.43, 2.9}, {240, 200, 4.2, 0.43, 2.8}};
  c.read_noise = 0.0071;
  int droplets = 0, alone = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::vector<Frame> frames;
    for (std::uint32_t k = 0; k < 6; ++k) frames.push_back(frame_of(render_strobe(c, nullptr, 0, seed, k)));
    std::vector<const Frame*> five;
    for (int k = 0; k < 5; ++k) five.push_back(&frames[std::size_t(k)]);
    const auto background = find_background(five, true);
    for (const Frame* f : five) alone += find_droplets(*f, nullptr).state == PictureState::kDrop;
    REQUIRE(background);
    droplets += find_droplets(frames[5], &*background).state != PictureState::kNoDrop;
  }
  CHECK(alone > 5);  // of 60: the pictures are such
  CHECK(alone < 55);
  CHECK(droplets == 0);
}

TEST_CASE(
    "A droplet before a saturated ground is measured by the shape of its edge, within its stated "
    "deviations") {
  for (const double light : {1.05, 1.15, 1.3}) {
    double sum = 0, square = 0;
    int n = 0, covered = 0;
    for (std::uint64_t seed = 1200; seed < 1240; ++seed) {
      RandomStream r(seed, Purpose::kTest);
      StrobeCamera c = camera();
      c.light = light;
      c.blur_px = r.uniform(0.8, 2.2);
      c.spot = r.uniform(0, 1);
      c.opacity = r.uniform(0.7, 0.97);
      StrobeJet jet;
      jet.diameter_um = r.uniform(50, 110);
      const StrobePicture p = render_strobe(c, &jet, 100 + r.uniform(0, 10), seed, 0);
      const DropletPicture found = find_droplets(frame_of(p), nullptr);
      REQUIRE(found.state == PictureState::kDrop);
      const double off = found.main.diameter_px - p.truth.diameter_px;
      sum += off;
      square += off * off;
      covered += std::abs(off) < 1.96 * found.main.diameter_std_px;
      ++n;
    }
    CAPTURE(light, sum / n, std::sqrt(square / n), covered);
    CHECK(std::abs(sum / n) < 0.2);  // halfway between white and droplet: 0.3, 0.7 and 1.2 px too small
    CHECK(std::sqrt(square / n) < 0.25);
    CHECK(covered >= 36);
  }
}
