// The camera's driver against its twin: sweeps, settings, damaged and lost pictures, refusals.
#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "drivers/camera/camera.h"
#include "plant/twins/camera.h"
#include "tests/drivers/fake_rig.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::plant::CameraTwin;
using firn::plant::Exposure;
using firn::plant::TakenPicture;

namespace {

// The twin's link is stepped here as the world steps it.
class TwinCamera {
 public:
  explicit TwinCamera(int white = 255)
      : twin({}, [this, white](const Exposure& e) {
          exposures.push_back(e);
          return picture(e, white);
        }) {}

  static TakenPicture picture(const Exposure& e, int white) {
    TakenPicture p{32, 24, white, {}};
    for (int i = 0; i < 32 * 24; ++i)
      p.pixels.push_back(std::uint16_t((i * 37 + int(e.delay_us)) % (white + 1)));
    return p;
  }
  void take(std::string_view bytes, std::int64_t now_us) {
    if (!twin.link().connected()) twin.link().connect(now_us);
    twin.take(std::as_bytes(std::span(bytes.data(), bytes.size())), now_us);
  }
  void advance(std::int64_t now_us) {
    while (twin.link().next_send_us() <= now_us) out += twin.link().pop_send().bytes;
  }
  std::int64_t next_us() const { return twin.link().next_send_us(); }

  std::string out;
  std::vector<Exposure> exposures;
  CameraTwin twin;
};

using CameraFakeRig = test::FakeRig<Camera, TwinCamera>;

struct CameraLab {
  explicit CameraLab(int white = 255) : fake(white) {
    rig.lines = false;
    rig.open();
    REQUIRE(rig.run([&] { return camera.safe(); }, 5));
  }
  Result sweep(const Sweep& s) {
    rig.act([&](std::int64_t t, Effects& fx) { camera.sweep(s, t, fx); });
    rig.run([&] { return !camera.busy(); }, 120);
    REQUIRE_FALSE(rig.all<Result>().empty());
    return rig.all<Result>().back();
  }

  TwinCamera fake;
  Camera camera{CameraOptions{}};
  CameraFakeRig rig{camera, fake};
};

}  // namespace

TEST_CASE("A camera names itself and is safe") {
  CameraLab lab;
  CHECK(lab.camera.identity() == "simulated camera, serial 1");
  CHECK(lab.camera.state() == DeviceState::kSafe);
}

TEST_CASE("A sweep brings its pictures in order, each at its own delay, pixel for pixel") {
  const int white = GENERATE(255, 4095);
  CameraLab lab(white);
  const Result r = lab.sweep({5, 40.0, 12.5, 80.0, 3.0});
  CHECK(r.outcome == Outcome::kDone);
  CHECK(r.counted == 5);
  const auto shots = lab.rig.all<CameraShot>();
  REQUIRE(shots.size() == 5);
  for (int k = 0; k < 5; ++k) {
    const Exposure& e = lab.fake.exposures[std::size_t(k)];
    CHECK(e.delay_us == 40.0 + 12.5 * k);
    CHECK(e.exposure_us == 80.0);
    CHECK(e.gain_db == 3.0);
    CHECK(shots[std::size_t(k)].index == k);
    CHECK(shots[std::size_t(k)].picture.white == white);
    CHECK(shots[std::size_t(k)].picture.pixels == lab.fake.picture(e, white).pixels);
  }
}

TEST_CASE("The age of a picture leads back to its exposure, up to the line's latency") {
  CameraLab lab;
  lab.sweep({1, 40.0, 0.0, 5000.0, 0.0});
  std::int64_t answered_us = lab.rig.now_us;
  const std::int64_t age_us = lab.rig.all<CameraShot>().at(0).picture.age_us;
  CHECK(std::llabs(answered_us - age_us - lab.fake.exposures.at(0).t_us) <= lab.rig.latency_us + 1);
}

TEST_CASE("An exposure of 0 is that of the lab file") {
  CameraLab lab;
  lab.sweep({});
  CHECK(lab.fake.exposures.at(0).exposure_us == CameraOptions{}.exposure_us);
}

TEST_CASE("Values outside the limits are refused by name before anything is sent") {
  CameraLab lab;
  const auto refused = [&](const Sweep& s, const char* text) {
    const auto before = lab.rig.bytes_sent;
    const Result r = lab.sweep(s);
    CHECK(r.outcome == Outcome::kRefused);
    CHECK_THAT(r.text, Catch::Contains(text));
    CHECK(lab.rig.bytes_sent == before);
  };
  refused({0, 1.0, 1.0}, "a sweep of 0 pictures is outside [1, 1000]");
  refused({1, -1.0, 1.0}, "a strobe delay of -1 us");
  refused({1000, 0.0, 1e8}, "a strobe delay of 9.99e+10 us");
  refused({1, 0.0, 0.0, 1e8}, "an exposure of 1e+08 us");
  refused({1, 0.0, 0.0, 1.0, std::nan("")}, "a gain of nan dB");
}

TEST_CASE("What the camera refuses ends the sweep with its own words") {
  CameraLab lab;
  lab.fake.twin.trip(0, 1);
  const Result r = lab.sweep({3, 1.0, 1.0});
  CHECK(r.outcome == Outcome::kFailed);
  CHECK_THAT(r.text, Catch::Contains("it refuses SNAP: the sensor is disconnected"));
  CHECK(lab.camera.safe());
  lab.fake.twin.trip(0, 0);
  CHECK(lab.sweep({3, 1.0, 1.0}).outcome == Outcome::kDone);
}

TEST_CASE("A damaged picture is never taken for one, and is asked for again") {
  CameraLab lab;
  int damaged = 0;
  lab.rig.line = [&](std::string& said) -> std::int64_t {
    if (said.starts_with("OK SNAP") && damaged++ == 1) said.back() = char(said.back() ^ 1);
    return 0;
  };
  CHECK(lab.sweep({3, 1.0, 1.0}).outcome == Outcome::kDone);
  CHECK(damaged == 4);
  const auto shots = lab.rig.all<CameraShot>();
  REQUIRE(shots.size() == 3);
  for (const CameraShot& s : shots)
    CHECK(s.picture.pixels == lab.fake.picture({0, 0, 0, s.sweep.delay_of(s.index), 0}, 255).pixels);
}

TEST_CASE("Pictures cut into pieces of any size come whole") {
  CameraLab lab;
  lab.rig.split = GENERATE(1, 7, 100);
  CHECK(lab.sweep({2, 1.0, 1.0}).outcome == Outcome::kDone);
  CHECK(lab.rig.all<CameraShot>().size() == 2);
}

TEST_CASE("A camera that falls silent ends the sweep as failed, and is used again when it answers") {
  CameraLab lab;
  lab.rig.hung = true;
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.camera.sweep({3, 1.0, 1.0}, t, fx); });
  lab.rig.run_for(30);
  lab.rig.hung = false;
  REQUIRE(lab.rig.run([&] { return lab.camera.safe() && !lab.camera.busy(); }, 60));
  CHECK(lab.rig.all<Result>().back().outcome == Outcome::kFailed);
  CHECK(lab.sweep({3, 1.0, 1.0}).outcome == Outcome::kDone);
}

TEST_CASE("A stop ends a sweep, and a picture that comes after it belongs to none") {
  CameraLab lab;
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.camera.sweep({100, 1.0, 1.0}, t, fx); });
  lab.rig.run([&] { return lab.rig.all<CameraShot>().size() == 3; }, 10);
  lab.rig.act([&](std::int64_t t, Effects& fx) { lab.camera.safe_stop(t, fx); });
  CHECK(lab.camera.safe());
  CHECK(lab.rig.all<Result>().back().outcome == Outcome::kFailed);
  lab.rig.run_for(1);
  CHECK(lab.rig.all<CameraShot>().size() == 3);
}

TEST_CASE("Checksums differ when any one bit of a picture does") {
  firn::RandomStream random(1, firn::Purpose::kTest);
  std::vector<std::byte> bytes(1 + random.below(3000));
  for (std::byte& b : bytes) b = std::byte(random.below(256));
  const auto sum = picture_line::checksum(bytes);
  for (int n = 0; n < 200; ++n) {
    auto other = bytes;
    other[random.below(std::uint32_t(bytes.size()))] ^= std::byte(1u << random.below(8));
    CHECK(picture_line::checksum(other) != sum);
  }
}

TEST_CASE("The head of a picture is refused where a number lies or is missing") {
  using picture_line::parse_head;
  CHECK(parse_head("1 32 24 255 0 768 5"));
  CHECK(parse_head("1 32 24 4095 0 1536 5"));
  for (const char* text : {"", "1 32 24 255 0 768", "1 32 24 255 0 769 5", "1 32 24 256 0 768 5",
                           "1 8 24 255 0 192 5", "1 32 99999 255 0 3199968 5", "1 32 24 255 -1 768 5",
                           "1 32 24 255 0 768 5 6", "x 32 24 255 0 768 5", "1 32 24 255 0 768 4294967296"})
    CHECK_FALSE(parse_head(text));
}
