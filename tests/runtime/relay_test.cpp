// Frames, their order and the other host's clock: the line to another computer of a run.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "runtime/relay/frame.h"
#include "runtime/relay/peer_clock.h"
#include "runtime/relay/send_queue.h"
#include "runtime/run_clock.h"

namespace firn::relay {
namespace {

struct Kept {
  FrameKind kind;
  std::string name;
  std::int64_t number, second;
  std::string bytes;
  bool operator==(const Kept&) const = default;
};
Kept kept(const Frame& f) { return {f.kind, std::string(f.name), f.number, f.second, std::string(f.text())}; }

Frame frame_of(const Kept& k) {
  return {k.kind, k.name, k.number, k.second, std::as_bytes(std::span(k.bytes.data(), k.bytes.size()))};
}

std::vector<Kept> random_frames(std::mt19937& random, int count) {
  std::vector<Kept> frames;
  for (int n = 0; n < count; ++n) {
    Kept k{FrameKind(1 + random() % 8), std::string(random() % 256, 'a' + char(random() % 26)),
           std::int64_t(random()) << 31, -std::int64_t(random()),
           std::string(random() % 3000, char(random()))};
    frames.push_back(k);
  }
  return frames;
}

std::vector<Kept> read(std::span<const std::byte> bytes) {
  FrameReader reader;
  reader.add(bytes);
  std::vector<Kept> frames;
  while (const auto f = reader.next()) frames.push_back(kept(*f));
  return frames;
}

Kept datagram(const std::string& channel, const std::string& message, char mac = 'm') {
  return {FrameKind::kDatagram, channel, 0, 0, message + std::string(32, mac)};
}

std::vector<Kept> all_of(SendQueue& queue, std::int64_t now_ns = 1) {
  std::vector<std::byte> bytes;
  while (queue.next(now_ns, 1000, bytes)) {
  }
  return read(bytes);
}

}  // namespace

TEST_CASE("frames come out of the stream as they went in, whatever its pieces", "[relay]") {
  std::mt19937 random(7);
  const std::vector<Kept> sent = random_frames(random, 200);
  std::vector<std::byte> stream;
  for (const Kept& k : sent) append_frame(frame_of(k), stream);
  FrameReader reader;
  std::vector<Kept> got;
  for (std::size_t at = 0; at < stream.size();) {
    const std::size_t size = std::min<std::size_t>(stream.size() - at, 1 + random() % 700);
    reader.add(std::span(stream).subspan(at, size));
    at += size;
    while (const auto f = reader.next()) got.push_back(kept(*f));
  }
  CHECK(got == sent);
}

TEST_CASE("a stream that is no frames is refused at its byte", "[relay]") {
  std::vector<std::byte> stream;
  append_frame({FrameKind::kLine, "jet", 0, 0, {}}, stream);
  const std::size_t good = stream.size();
  const std::string at = "byte " + std::to_string(good);
  const auto refusal = [&](std::vector<std::byte> more) {
    std::vector<std::byte> all = stream;
    all.insert(all.end(), more.begin(), more.end());
    try {
      read(all);
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string("taken");
  };
  const auto zeros = [](std::size_t n) { return std::vector<std::byte>(n); };
  CHECK(refusal(zeros(4)).starts_with(at));
  CHECK(refusal({std::byte{0xff}, std::byte{0}, std::byte{0}, std::byte{0}}).starts_with(at));
  auto unknown = zeros(4 + 18);
  unknown[3] = std::byte{18};
  unknown[4] = std::byte{99};
  CHECK(refusal(unknown).find("kind 99") != std::string::npos);
  unknown[4] = std::byte{2};
  unknown[4 + 17] = std::byte{1};
  CHECK(refusal(unknown).find("name longer") != std::string::npos);
}

TEST_CASE("a frame beyond the limits is not sent", "[relay]") {
  std::vector<std::byte> to;
  const std::vector<std::byte> large(kMaxFrameBytes);
  CHECK_THROWS_AS(append_frame({FrameKind::kFile, "x", 0, 0, large}, to), std::length_error);
  const std::string name(kMaxNameBytes + 1, 'n');
  CHECK_THROWS_AS(append_frame({FrameKind::kFile, name, 0, 0, {}}, to), std::length_error);
  CHECK(to.empty());
}

TEST_CASE("bytes of a port that may be many wait for their turn, those of others go before all messages",
          "[relay]") {
  SendQueue queue;
  queue.add(frame_of(datagram("HEIGHT_MAP", "map")));
  const auto add = [&](const std::string& port, std::int64_t piece) {
    queue.add(frame_of({FrameKind::kPort, port, piece, 1, "bytes"}));
  };
  for (std::int64_t piece = 1; piece < 4; ++piece) {
    add("laser_profiler", piece);
    add("lamp", piece);
  }
  std::vector<std::string> names;
  std::vector<std::int64_t> pieces;
  for (const Kept& k : all_of(queue)) {
    names.push_back(k.name);
    pieces.push_back(k.number);
  }
  CHECK(names == std::vector<std::string>{"lamp", "lamp", "lamp", "HEIGHT_MAP", "laser_profiler",
                                          "laser_profiler", "laser_profiler"});
  CHECK(pieces == std::vector<std::int64_t>{1, 2, 3, 0, 1, 2, 3});
}

TEST_CASE("a stop leaves before all maps that wait", "[relay]") {
  SendQueue queue;
  for (int n = 0; n < 20; ++n)
    queue.add(frame_of(datagram("HEIGHT_PROFILE", std::string(5000, char('a' + n)))));
  queue.add(frame_of(datagram("SAFE_STOP", "stop")));
  std::vector<std::byte> bytes;
  REQUIRE(queue.next(1, 1, bytes));
  CHECK(read(bytes).front().name == "SAFE_STOP");
}

TEST_CASE("messages keep their order", "[relay]") {
  SendQueue queue;
  std::vector<Kept> sent;
  for (int n = 0; n < 50; ++n) {
    sent.push_back(datagram("HEIGHT_PROFILE", "row " + std::to_string(n)));
    queue.add(frame_of(sent.back()));
  }
  CHECK(all_of(queue) == sent);
}

TEST_CASE("of a channel whose newest message counts only that one waits", "[relay]") {
  SendQueue queue;
  for (int n = 0; n < 5; ++n) queue.add(frame_of(datagram("ENABLE", "lease " + std::to_string(n))));
  const auto left = all_of(queue);
  REQUIRE(left.size() == 1);
  CHECK(left[0] == datagram("ENABLE", "lease 4"));
}

TEST_CASE("a message that waits is not queued a second time", "[relay]") {
  SendQueue queue;
  queue.add(frame_of(datagram("LAYER_PLAN", "plan", '1')));
  queue.add(frame_of(datagram("LAYER_PLAN", "plan", '2')));
  CHECK(all_of(queue).size() == 1);
  queue.add(frame_of(datagram("LAYER_PLAN", "plan", '3')));  // asked for again, later
  CHECK(all_of(queue).size() == 1);
}

TEST_CASE("a line that does not move holds a bounded number of bytes", "[relay]") {
  SendQueue queue;
  for (int n = 0; n < 3000; ++n)
    queue.add(frame_of(datagram("HEIGHT_PROFILE", std::string(20'000, char(n)) + std::to_string(n))));
  CHECK(queue.waiting_bytes() <= SendQueue::kMostWaitingBytes);
  CHECK(queue.dropped() > 0);
}

TEST_CASE("no more bytes are on the way than the window", "[relay]") {
  SendQueue queue;
  for (int n = 0; n < 100; ++n)
    queue.add(frame_of(datagram("HEIGHT_PROFILE", std::string(20'000, char(n)) + std::to_string(n))));
  std::vector<std::byte> bytes;
  while (queue.next(1, 1000, bytes)) {
  }
  CHECK(std::int64_t(bytes.size()) < SendQueue::kFirstWindow + 20'100);
  queue.taken(std::int64_t(bytes.size()), 2);
  bytes.clear();
  CHECK(queue.next(3, 1000, bytes));
}

TEST_CASE("the window follows what the line carries", "[relay]") {
  // A line of 1 MB/s and 40 ms: 40 kB are on the way; 1.5 times the bytes of 50 ms may be.
  const auto window_of = [](double bytes_per_s) {
    SendQueue queue;
    queue.set_round_trip_ns(40'000'000);
    std::int64_t now = 1, taken = 0;
    for (int n = 0; n < 4000; ++n) {
      queue.add(frame_of(datagram("HEIGHT_PROFILE", std::string(20'000, char(n)) + std::to_string(n))));
      std::vector<std::byte> bytes;
      while (queue.next(now, 1000, bytes)) {
      }
      now += std::int64_t(double(bytes.size()) / bytes_per_s * 1e9) + 1;
      taken += std::int64_t(bytes.size());
      queue.taken(taken, now);
    }
    return double(queue.window_bytes());
  };
  CHECK(window_of(2e6) == Approx(1.5 * 2e6 * 0.05).epsilon(0.1));
  CHECK(window_of(20e6) == Approx(1.5 * 20e6 * 0.05).epsilon(0.1));
  CHECK(window_of(1e5) == double(SendQueue::kLeastWindow));
}

TEST_CASE("a file's pieces leave when no message waits", "[relay]") {
  SendQueue queue;
  int pieces = 3;
  queue.set_files([&](std::vector<std::byte>& frame) {
    if (pieces == 0) return false;
    append_frame({FrameKind::kFile, "nodes/jet.wal", --pieces, 0, {}}, frame);
    return true;
  });
  queue.add(frame_of(datagram("LAYER_PLAN", "plan")));
  const auto left = all_of(queue);
  REQUIRE(left.size() == 4);
  CHECK(left[0].kind == FrameKind::kDatagram);
  CHECK(left[3].kind == FrameKind::kFile);
}

TEST_CASE("the other clock's difference lies within its bound, whatever the line does", "[relay]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 40; ++trial) {
    const double drift = (unit(random) - 0.5) * 2.0 * PeerClock::kMostDrift;
    const std::int64_t ahead = std::int64_t((unit(random) - 0.5) * 1e18);
    const double base_ns = unit(random) * 20e6, jitter_ns = unit(random) * 10e6;
    const auto theirs = [&](std::int64_t t) { return t + ahead + std::int64_t(drift * double(t)); };
    PeerClock clock;
    std::int64_t now = 5'000'000'000;
    for (int n = 0; n < 100; ++n) {
      const std::int64_t sent = now;
      const std::int64_t told = sent + std::int64_t(base_ns + jitter_ns * unit(random));
      now = told + std::int64_t(base_ns * 0.7 + jitter_ns * unit(random));
      clock.add(sent, theirs(told), now);
      const auto e = clock.at(now);
      REQUIRE(e);
      const double error = std::abs(double(e->ahead_ns - (theirs(now) - now)));
      CHECK(error <= double(e->bound_ns) + 1000.0);
      now += 100'000'000;
    }
  }
}

TEST_CASE("a clock that leaps is known anew from its next answer", "[relay]") {
  PeerClock clock;
  for (int n = 0; n < 20; ++n) clock.add(n * 1000, n * 1000 + 500, n * 1000 + 900);
  clock.add(100'000, 100'400 + 3'000'000'000, 100'900);
  const auto e = clock.at(100'900);
  REQUIRE(e);
  CHECK(std::abs(e->ahead_ns - 3'000'000'000) <= e->bound_ns);
  CHECK(e->bound_ns < 2000);
}

TEST_CASE("a steered node clock never goes back and meets the other one", "[relay]") {
  std::mt19937 random(3);
  for (const double scale : {1.0, 10.0}) {
    RunClock clock(0, 1000, scale);
    const double drift = 200e-6;
    const std::int64_t first_error_us = std::int64_t(800.0 * scale);  // below kMostSlew * kSlewS
    const auto launcher = [&](std::int64_t mono_ns) {
      return Time{std::int64_t(double(mono_ns) * scale * (1.0 + drift) * 1e-3) + 1000 + first_error_us};
    };
    Time last{0};
    std::int64_t now = 1'000'000'000;
    for (int n = 0; n < 200; ++n) {
      clock.follow({now, launcher(now)}, now + std::int64_t(random() % 1'000'000));
      for (int k = 0; k < 10; ++k) {
        now += 25'000'000;
        const Time t = clock.at_ns(now);
        REQUIRE(t >= last);
        last = t;
      }
    }
    CHECK(std::abs(double(clock.at_ns(now).us - launcher(now).us)) < 300.0 * scale);
  }
}

TEST_CASE("the wall time of a steered clock's node time is that node time", "[relay]") {
  RunClock clock(1'000'000'000, 0, 2.0);
  clock.follow({2'000'000'000, Time{2'000'500}}, 2'100'000'000);
  for (const std::int64_t us : {2'300'000, 5'000'000, 90'000'000}) {
    const std::int64_t wall = clock.wall_us({us});
    CHECK(clock.at_ns(wall * 1000).us >= us);
    CHECK(clock.at_ns((wall - 2) * 1000).us <= us);
  }
}

}  // namespace firn::relay
