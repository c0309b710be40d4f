// The camera's node: pictures of the instrument become messages with PNGs, previews are few.
#include <catch2/catch.hpp>

#include "core/grid/png.h"
#include "firn/camera_frame_t.hpp"
#include "firn/camera_preview_t.hpp"
#include "firn/enable_t.hpp"
#include "plant/twins/camera.h"
#include "procs/camera/node.h"
#include "tests/support/node_bench.h"

namespace firn::test {
namespace {

struct CameraLab : NodeBench {
  explicit CameraLab(int w = 640, int h = 480, int top = 4095)
      : NodeBench(NodeId::kCamera, std::make_unique<CameraNode>(Experiment{})),
        width(w),
        height(h),
        white(top),
        twin({}, [this](const plant::Exposure& e) { return picture(e); }) {
    start();
    link(0, LinkState::kOpen);
    twin.link().connect(now.us);
    run_until([this] {
      return !all(channels::device_state(NodeId::kCamera)).empty() &&
             DeviceState(last(channels::device_state(NodeId::kCamera)).state) == DeviceState::kSafe;
    });
    enable_t lease{};
    lease.enable_epoch = 1;
    lease.enabled = 1;
    lease.lease_s = 10.0;
    give(channels::kEnable, lease);
  }
  plant::TakenPicture picture(const plant::Exposure& e) {
    exposed_us.push_back(e.t_us);
    plant::TakenPicture p{width, height, white, {}};
    for (int i = 0; i < width * height; ++i)
      p.pixels.push_back(std::uint16_t((i + int(e.delay_us)) % (white + 1)));
    return p;
  }
  template <class Done>
  void run_until(Done&& done) {
    for (int n = 0; n < 2000 && !done(); ++n) {
      const std::vector<std::byte> bytes = std::exchange(written, {});
      if (!bytes.empty()) twin.take(bytes, now.us);
      now.us += 1000;
      for (auto timer = host.next_timer(); timer && timer->at <= now; timer = host.next_timer()) wake();
      while (twin.link().next_send_us() <= now.us) {
        const std::string said = twin.link().pop_send().bytes;
        io(0, std::as_bytes(std::span(said.data(), said.size())));
      }
    }
    REQUIRE(done());
  }
  void sweep(int frames) {
    camera_command_t c{};
    c.command_id = ++command;
    c.enable_epoch = 1;
    c.verb = std::int8_t(CameraVerb::kSweep);
    c.layer = 2;
    c.sweep_id = 9;
    c.frames = frames;
    c.delay_us = 50;
    c.step_us = 10;
    give(channels::kCameraCommand, c);
    run_until([this] { return !all(channels::answer(NodeId::kCamera)).empty(); });
    const answer_t a = last(channels::answer(NodeId::kCamera));
    INFO(a.text);
    REQUIRE(Outcome(a.outcome) == Outcome::kDone);
  }

  int width, height, white;
  std::vector<std::int64_t> exposed_us;
  plant::CameraTwin twin;
  std::int64_t command = 0;
};

}  // namespace

TEST_CASE("Pictures come as PNGs of the pixels' own depth, with delay, sweep and the exposure's time") {
  CameraLab lab;
  lab.sweep(4);
  const auto frames = lab.all(channels::kCameraFrame);
  REQUIRE(frames.size() == 4);
  for (int k = 0; k < 4; ++k) {
    const camera_frame_t& m = frames[std::size_t(k)];
    CHECK(m.index == k);
    CHECK(m.frames == 4);
    CHECK(m.sweep_id == 9);
    CHECK(m.layer == 2);
    CHECK(m.delay_us == 50.0 + 10.0 * k);
    CHECK(m.white == 4095);
    const GreyPicture grey = read_grey_png(std::as_bytes(std::span(m.png)));
    CHECK(grey.white == 65535.0);
    CHECK(grey.pixels[5000] == (5000 + 50 + 10 * k) % 4096);
    CHECK(std::llabs(m.sample_utime_us - lab.exposed_us[std::size_t(k)]) <= 2000);
  }
}

TEST_CASE("A preview is at most 60 kB, and one comes each half second") {
  CameraLab lab(2048, 1536, 255);
  lab.sweep(30);
  const auto previews = lab.all(channels::kCameraPreview);
  const double s = 1e-6 * double(lab.exposed_us.back() - lab.exposed_us.front());
  CHECK(previews.size() >= 1);
  CHECK(double(previews.size()) <= 2.0 * s + 2.0);
  for (const camera_preview_t& p : previews) {
    CHECK(p.n <= 60'000);
    CHECK(p.n == p.width * p.height);
    CHECK(p.grey.size() == std::size_t(p.n));
  }
}

}  // namespace firn::test
