// The link state machine under hostile replies; properties that hold for every driver.
#include <catch2/catch.hpp>

#include "drivers/gas/gas.h"
#include "drivers/heater/heater.h"
#include "drivers/jet/jet.h"
#include "drivers/jet/microdrop.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/link/link.h"
#include "drivers/robot/robot.h"
#include "drivers/stage/stage.h"
#include "drivers/valve/valve.h"
#include "tests/drivers/bench.h"
#include "tests/drivers/lossy_line.h"

using namespace firn::drivers;
using firn::DeviceState;
using firn::Outcome;
using firn::drivers::test::Bench;
using firn::drivers::test::bytes_of;
using firn::drivers::test::next;

namespace {

Request line(std::string_view text, Repeat repeat, std::uint16_t tag,
             ensemble::Format format = ensemble::kValue) {
  Request r;
  r.append(text);
  r.append("\n");
  r.repeat = repeat;
  r.tag = tag;
  r.format = format;
  return r;
}

}  // namespace

TEST_CASE("a reply of 60 ms against a timeout of 20 ms gives no wrong reading", "[link]") {
  // The instrument answers question n with n; every 50th answer comes 60 ms late. A driver that takes
  // the next reply for its answer gave 949 wrong readings of 1000.
  ensemble::EnsembleDialect dialect;
  dialect.timeouts = {2'000'000, 0, 20'000, 5'000, 100'000, 0};
  Link link(dialect);
  Effects fx;
  std::int64_t now_us = 0;
  std::vector<std::pair<std::int64_t, std::string>> under_way;  // arrival time, bytes
  int asked = 0, right = 0, wrong = 0, suspect = 0, answered = 0;
  link.opened(now_us);
  while (right + wrong < 1000) {
    fx.clear();
    while (const auto e = link.poll(now_us, fx)) {
      if (e->kind == LinkEvent::Kind::kReply) {
        const auto n = dialect.parse(e->frame).number();
        (n && int(*n) == e->request.tag ? right : wrong)++;
      }
      suspect += e->kind == LinkEvent::Kind::kSuspect;
      if (link.idle()) {
        link.push(line("Q" + std::to_string(asked % 60'000), Repeat::kRead, std::uint16_t(asked % 60'000)));
        ++asked;
      }
    }
    if (!fx.tx.empty()) {
      const std::string sent(reinterpret_cast<const char*>(fx.tx.data()), fx.tx.size());
      const std::string value = sent[0] == 'Q' ? sent.substr(1) : "0\n";  // PLANESTATUS is the probe
      under_way.emplace_back(now_us + (++answered % 50 == 0 ? 60'000 : 1'000), "%" + value);
    }
    std::int64_t when = link.wake_us() == 0 ? INT64_MAX : link.wake_us();
    std::size_t first = under_way.size();
    for (std::size_t n = 0; n < under_way.size(); ++n)
      if (under_way[n].first < when) {
        when = under_way[n].first;
        first = n;
      }
    REQUIRE(when != INT64_MAX);
    now_us = std::max(now_us, when);
    if (first == under_way.size()) continue;
    const std::string arrived = under_way[first].second;
    under_way.erase(under_way.begin() + std::ptrdiff_t(first));
    link.received(bytes_of(arrived), now_us);
  }
  CHECK(wrong == 0);
  CHECK(suspect >= 15);
}

TEST_CASE("a request that acts is sent once whatever becomes of its reply, and a question is asked again",
          "[link]") {
  for (const Repeat repeat : {Repeat::kRead, Repeat::kSetup, Repeat::kNever}) {
    ensemble::EnsembleDialect dialect;
    Link link(dialect);
    Effects fx;
    std::int64_t now_us = 0;
    int sent = 0, failed = 0;
    link.opened(now_us);
    bool pushed = false;
    for (int n = 0; n < 1000; ++n) {
      fx.clear();
      while (const auto e = link.poll(now_us, fx)) {
        if (e->kind == LinkEvent::Kind::kReady) {
          link.push(line("LINEAR @0 1 F1", repeat, 1, ensemble::kAcknowledge));
          pushed = true;
        }
        failed += e->kind == LinkEvent::Kind::kFailed;
      }
      const std::string tx(reinterpret_cast<const char*>(fx.tx.data()), fx.tx.size());
      sent += tx.find("LINEAR") != std::string::npos;
      if (tx.find("PLANESTATUS") != std::string::npos)
        link.received(bytes_of("%0\n"), now_us);  // the probe is answered
      else if (link.wake_us() != 0)
        now_us = std::max(now_us, link.wake_us());
    }
    CHECK(pushed);
    CHECK(failed == 1);
    CHECK(sent == (repeat == Repeat::kNever ? 1 : dialect.max_attempts));
  }
}

TEST_CASE(
    "where replies name their request, it is sent again with the same bytes, three times, then the link is "
    "lost",
    "[link]") {
  fvp::FvpDialect dialect;
  Link link(dialect);
  Effects fx;
  std::int64_t now_us = 0;
  link.opened(now_us);
  REQUIRE(link.poll(now_us, fx)->kind == LinkEvent::Kind::kReady);
  LineWriter line = fvp::request(5, "PATH RUN 1 1");
  link.push(fvp::to_request(line, 5, Repeat::kNever, 0));
  std::vector<std::string> sent;
  bool lost = false;
  for (int n = 0; n < 10 && !lost; ++n) {
    fx.clear();
    while (const auto e = link.poll(now_us, fx)) lost = lost || e->kind == LinkEvent::Kind::kLost;
    if (!fx.tx.empty()) sent.emplace_back(reinterpret_cast<const char*>(fx.tx.data()), fx.tx.size());
    if (link.wake_us() != 0) now_us = link.wake_us();
  }
  CHECK(lost);
  CHECK(now_us == 750'000);
  CHECK(sent == std::vector<std::string>(3, "@5 PATH RUN 1 1*" + sent.at(0).substr(16, 4) + "\r\n"));
}

TEST_CASE("what a stop has overtaken is never sent again, and its late reply answers nothing", "[link]") {
  fvp::FvpDialect dialect;
  Link link(dialect);
  Effects fx;
  link.opened(0);
  REQUIRE(link.poll(0, fx)->kind == LinkEvent::Kind::kReady);
  LineWriter run = fvp::request(5, "PATH RUN 1 1"), stop = fvp::request(6, "STOP");
  link.push(fvp::to_request(run, 5, Repeat::kNever, 1));
  CHECK_FALSE(link.poll(0, fx));
  link.urgent(fvp::to_request(stop, 6, Repeat::kSetup, 2), 1000, fx);
  fx.clear();
  LineWriter reply = fvp::request(6, "ACK"), late = fvp::request(5, "ACK");
  link.received(bytes_of(reply.finish(1)), 2000);
  const auto answered = link.poll(2000, fx);
  REQUIRE(answered);
  CHECK(answered->kind == LinkEvent::Kind::kReply);
  CHECK(answered->request.tag == 2);
  const auto overtaken = link.poll(2000, fx);
  REQUIRE(overtaken);
  CHECK(overtaken->kind == LinkEvent::Kind::kFailed);
  CHECK(overtaken->request.tag == 1);
  link.received(bytes_of(late.finish(1)), 3000);
  CHECK_FALSE(link.poll(3000, fx));
  CHECK_FALSE(link.poll(10'000'000, fx));
  CHECK(fx.tx.empty());
  CHECK(link.idle());
}

TEST_CASE(
    "a value that nobody asked for puts the link under suspicion instead of shifting all answers by one",
    "[link]") {
  ensemble::EnsembleDialect dialect;
  Link link(dialect);
  Effects fx;
  link.opened(0);
  REQUIRE(link.poll(0, fx)->kind == LinkEvent::Kind::kReady);
  link.push(line("ENABLE @0", Repeat::kSetup, 1, ensemble::kAcknowledge));
  CHECK_FALSE(link.poll(0, fx));
  link.received(bytes_of("%17\n"), 10);
  REQUIRE(link.poll(10, fx)->kind == LinkEvent::Kind::kSuspect);
  CHECK(link.suspect());
}

TEST_CASE("what makes safe is sent at once, while a reply is awaited and while the link is suspect",
          "[link]") {
  ensemble::EnsembleDialect dialect;
  Link link(dialect);
  Effects fx;
  link.opened(0);
  REQUIRE(link.poll(0, fx)->kind == LinkEvent::Kind::kReady);
  link.push(line("PFBKPROG(@0)", Repeat::kRead, 1));
  link.push(line("PFBKPROG(@1)", Repeat::kRead, 2));
  link.poll(0, fx);
  fx.clear();
  link.urgent(line("ABORT @0", Repeat::kSetup, 3, ensemble::kAcknowledge), 5, fx);
  CHECK(fx.tx.size() == 9);
  link.received(bytes_of("%1.5\n%\n"), 10);
  const auto first = link.poll(10, fx), second = link.poll(10, fx);
  REQUIRE((first && second));
  CHECK(first->request.tag == 1);
  CHECK(second->request.tag == 3);
  link.poll(10, fx);
  while (!link.suspect()) link.poll(link.wake_us(), fx);  // PFBKPROG(@1) stays unanswered
  fx.clear();
  link.urgent(line("ABORT @0", Repeat::kSetup, 4, ensemble::kAcknowledge), 3'000'000, fx);
  CHECK(fx.tx.size() == 9);
}

TEST_CASE("a link that cannot be recovered is opened anew, with pauses that double", "[link][I2]") {
  Stage stage(StageOptions{});
  Bench bench(stage);
  bench.open();
  std::vector<std::int64_t> reopened_at;
  for (int n = 0; n < 9; ++n) {
    while (bench.reopens == n) {
      REQUIRE(bench.advance_to_wake());
      REQUIRE(bench.now_us < 1'000'000'000);
    }
    reopened_at.push_back(bench.now_us);
    bench.close();
    bench.open();  // and nobody answers
  }
  std::vector<std::int64_t> gaps;
  for (std::size_t n = 1; n < reopened_at.size(); ++n) gaps.push_back(reopened_at[n] - reopened_at[n - 1]);
  // Each holds the same time without an answer and a pause of 0.2, 0.4, 0.8, 1.6, 3.2, 5, 5, 5 s.
  std::vector<std::int64_t> longer;
  for (std::size_t n = 1; n < gaps.size(); ++n) longer.push_back(gaps[n] - gaps[n - 1]);
  CHECK(longer == std::vector<std::int64_t>{200'000, 400'000, 800'000, 1'600'000, 1'800'000, 0, 0});
}

namespace {
template <class DriverType, class Config>
struct Kind {
  using Type = DriverType;
  using ConfigType = Config;
};
}  // namespace

TEMPLATE_TEST_CASE("random bytes never crash a driver, never make it spin, and never make it SAFE", "[link]",
                   (Kind<Stage, StageOptions>), (Kind<Jet, JetOptions>), (Kind<Microdrop, JetOptions>),
                   (Kind<LaserProfiler, LaserProfilerOptions>), (Kind<Lamp, LampOptions>),
                   (Kind<Robot, RobotOptions>), (Kind<Valve, ValveOptions>),
                   (Kind<LaserPoint, LaserPointOptions>), (Kind<Heater, HeaterOptions>),
                   (Kind<Gas, GasOptions>)) {
  std::uint64_t seed = 99;
  for (int round = 0; round < 40; ++round) {
    typename TestType::Type driver{typename TestType::ConfigType{}};
    Bench bench(driver);
    bench.open();
    for (int n = 0; n < 200; ++n) {
      std::string noise;
      for (std::size_t k = next(seed) % 40; k > 0; --k) noise += char(next(seed));
      if (next(seed) % 4 == 0) noise += "\r\n";
      bench.feed(noise);
      if (next(seed) % 3 == 0) bench.advance_us(std::int64_t(next(seed) % 500'000));
      if (next(seed) % 20 == 0) bench.safe_stop();
      if (next(seed) % 40 == 0) {
        bench.close();
        bench.open();
      }
      CHECK_FALSE(driver.safe());
    }
    CHECK(bench.wake_us() != 0);  // it will try again
  }
}

TEST_CASE("no flipped bit of a jet reply is taken for a reply", "[jet]") {
  const jetdrive::JetDriveDialect dialect;
  const std::uint8_t external[] = {1};
  const Request asked = jetdrive::frame(jetdrive::Command::kSource, external, Repeat::kNever);
  const std::string good("\x06\x08\x00\x08", 4);
  REQUIRE(dialect.frame(bytes_of(good), &asked).kind == Frame::Kind::kReply);
  for (int bit = 0; bit < 32; ++bit) {
    std::string bad = good;
    bad[std::size_t(bit / 8)] = char(bad[std::size_t(bit / 8)] ^ 1 << bit % 8);
    CHECK(dialect.frame(bytes_of(bad), &asked).kind == Frame::Kind::kCorrupt);
  }
}

TEST_CASE("the waveform is never changed while the jet may fire, and never beyond its caps", "[jet][I11]") {
  Jet jet(JetOptions{});
  Bench bench(jet);
  bench.open();
  const auto answer = [&] {  // everything is acknowledged
    while (!bench.tx.empty()) {
      const std::string sent = bench.take();
      if (sent[0] != 'S' || sent.size() == 1) {
        bench.feed(sent == "Q" ? ">" : sent);
        continue;
      }
      std::string reply{char(0x06), sent[2], char(0)};
      if (std::uint8_t(sent[2]) == 0xF0) reply += char(5);
      char sum = 0;
      for (std::size_t n = 1; n < reply.size(); ++n) sum = char(sum + reply[n]);
      bench.feed(reply + sum);
    }
  };
  while (jet.state() != DeviceState::kSafe) {
    answer();
    if (jet.state() != DeviceState::kSafe) REQUIRE(bench.advance_to_wake());
  }
  jetdrive::Waveform high;
  high.dwell_v = 101;
  bench.command([&](std::int64_t t, Effects& fx) { jet.set_waveform(high, t, fx); });
  CHECK(bench.all<Result>().back().code == kJetLimit);
  CHECK(bench.all<Result>().back().text.find("dwell voltage 101 V") != std::string::npos);
  jetdrive::Waveform slow;
  slow.echo_us = 1e6;
  bench.command([&](std::int64_t t, Effects& fx) { jet.set_waveform(slow, t, fx); });
  CHECK(bench.all<Result>().back().outcome == Outcome::kRefused);
  bench.command([&](std::int64_t t, Effects& fx) { jet.arm(1, t, fx); });
  answer();
  REQUIRE(jet.state() == DeviceState::kArmed);
  bench.command([&](std::int64_t t, Effects& fx) { jet.set_waveform(jetdrive::Waveform{}, t, fx); });
  CHECK(bench.all<Result>().back().code == kJetLimit);
  CHECK(bench.tx.empty());
  bench.safe_stop();
  CHECK(test::hex(bench.tx) == "53 03 08 00 0B");
  answer();
  CHECK(jet.safe());
  bench.command([&](std::int64_t t, Effects& fx) { jet.set_waveform(jetdrive::Waveform{}, t, fx); });
  answer();
  CHECK(bench.all<Result>().back().outcome == Outcome::kDone);
}
