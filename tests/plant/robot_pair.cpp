#include "tests/plant/robot_pair.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "plant/twins/fvp.h"
#include "plant/twins/lines.h"

namespace firn::plant {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr std::int64_t kReply_us = 2'000'000;  // more than the slowest controller needs for one line
constexpr double kCountDeg = 1e-4, kCountMm = 1e-3;

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string w; in >> w;) words.push_back(w);
  return words;
}

double angle_or_mm(const Joints& q, std::size_t n) {
  return n == 2 ? q[n] / kCountMm : q[n] / kDeg / kCountDeg;
}

IceWorldConfig with_program(IceWorldConfig config, const IceRobotProgram& program) {
  config.robot = program;
  return config;
}

/// The part of a reply that must be equal: the words, but for the reason of a NAK, which is for persons.
std::string essence(const std::string& reply) {
  const std::vector<std::string> w = words_of(reply);
  return w.size() >= 2 && w[0] == "NAK" ? "NAK " + w[1] : reply;
}

}  // namespace

RobotPair::RobotPair(const IceWorldConfig& config, const IceRobotProgram& program, std::uint64_t seed)
    : config_(config),
      random_(std::uint32_t(seed)),
      bench_{Bench(with_program(config, {})), Bench(with_program(config, program))} {
  run_for(3'000'000);  // the V+ program makes its table
  connect();
}

void RobotPair::run_for(std::int64_t us) {
  for (Bench& b : bench_) advance(b, us);
}

void RobotPair::advance(Bench& b, std::int64_t us) {
  const std::int64_t until_us = b.now_us + us, step_us = b.traced ? 2000 : us;
  while (b.now_us < until_us) {
    b.now_us = std::min(until_us, b.now_us + step_us);
    b.world.advance(b.now_us, [&](const World::Sent& s) {
      if (s.port == kRobotPort) b.heard.append(reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size());
    });
    const TrueArm& arm = b.world.ice()->nature().arm();
    if (b.traced && arm.newest_s() != b.newest_s) {
      b.newest_s = arm.newest_s();
      if (b.trace.empty() || arm.reference() != b.trace.back()) b.trace.push_back(arm.reference());
    }
  }
}

// The V+ twin gets its line in pieces that come one after the other.
void RobotPair::send(Bench& b, const std::string& line, bool cut) {
  std::size_t at = 0;
  while (at < line.size()) {
    const std::size_t piece = cut ? 1 + random_() % 60 : line.size();
    const std::string part = line.substr(at, piece);
    b.world.receive(kRobotPort, std::as_bytes(std::span(part.data(), part.size())), b.now_us);
    at += part.size();
    if (cut && at < line.size() && roll(3) == 0) advance(b, roll(8000));
  }
}

std::string RobotPair::reply_of(Bench& b, std::int64_t seq, std::int64_t limit_us) {
  const std::int64_t until_us = b.now_us + limit_us;
  for (;;) {
    for (std::size_t end; (end = b.heard.find('\n', b.read)) != std::string::npos;) {
      const auto m = drivers::fvp::parse(std::string_view(b.heard).substr(b.read, end + 1 - b.read));
      b.read = end + 1;
      if (m.kind == drivers::fvp::Message::Kind::kEvent) b.events.push_back(std::string(m.text));
      if (m.kind == drivers::fvp::Message::Kind::kNumbered && m.seq == seq) return std::string(m.text);
    }
    if (b.now_us >= until_us) return "";
    advance(b, std::clamp<std::int64_t>(b.world.next_event_us() - b.now_us, 100, until_us - b.now_us));
  }
}

RobotPair::Replies RobotPair::ask(const std::string& words) {
  ++counts_.commands;
  seq_ = drivers::fvp::next_seq(seq_);
  const std::string line = '@' + sealed(std::to_string(seq_) + ' ' + words);
  // The same fault of the line on both: the reply is lost, late, in parts, damaged, or follows an old one.
  constexpr FaultKind kOfALine[] = {FaultKind::kDropReply, FaultKind::kDelayReply, FaultKind::kSplitReply,
                                    FaultKind::kFlipBit, FaultKind::kStray};
  const bool disturbed = chance(0.15);
  const FaultKind fault = kOfALine[roll(5)];
  const std::int64_t bit = roll(400), delay_us = roll(20'000);
  Replies replies;
  for (std::size_t n = 0; n < 2; ++n) {
    Bench& b = bench_[n];
    if (disturbed)
      b.world.inject({"robot", fault, fault == FaultKind::kFlipBit ? bit : 1, delay_us}, b.now_us);
    for (int tries = 0; tries < 4 && replies[n].empty(); ++tries) {
      if (tries > 0) ++counts_.resent;
      send(b, line, n == 1);
      replies[n] = reply_of(b, seq_, kReply_us);
    }
  }
  if (essence(replies[0]).starts_with("NAK")) ++counts_.refused;
  return replies;
}

void RobotPair::differ(const std::string& what, const std::string& a, const std::string& b) {
  constexpr std::size_t kMost = 20;
  if (a != b && differences_.size() < kMost)
    differences_.push_back("command " + std::to_string(counts_.commands) + ", " + what + ": \"" + a +
                           "\" and \"" + b + "\"" +
                           (machine().stopped_by(0) + machine().stopped_by(1) + machine().stopped_by(2)));
}

void RobotPair::connect() {
  for (Bench& b : bench_) {
    b.world.connect(kRobotPort, b.now_us);
    b.read = b.heard.size();
  }
  seq_ = roll(60'000);
  const Replies r = ask("HELLO FIRN 1");
  differ("HELLO", r[0], r[1]);
}

// PATH_DONE and MOVE_DONE with their places within a count, MOTION_ERR with its error. Events come by
// themselves; a fault of the line may have taken one, which the protocol allows.
void RobotPair::compare_events(const std::string& when) {
  for (Bench& b : bench_) reply_of(b, -1, 50'000);
  std::array<std::string, 2> told;
  for (std::size_t n = 0; n < 2; ++n) {
    for (const std::string& e : bench_[n].events) {
      const std::vector<std::string> w = words_of(e);
      if (w.empty()) continue;
      told[n] += w[0];
      if (w[0] == "PATH_DONE" && w.size() > 1) told[n] += ' ' + w[1];
      if (w[0] == "MOTION_ERR" && w.size() > 3) told[n] += ' ' + w[3];
      told[n] += ';';
    }
    bench_[n].events.clear();
  }
  differ("events " + when, told[0], told[1]);
}

// STAT at rest: all of it but STATE(2), of which FVP/1's twin has no braking, points passed by a path that
// was stopped, and a path's time, which V+ measures by ticks.
std::array<int, 2> RobotPair::compare_status() {
  const Replies r = ask("STAT");
  std::array<std::vector<std::string>, 2> w{words_of(r[0]), words_of(r[1])};
  constexpr std::size_t kFields = 16, kState2 = 3, kAt = 10, kDone = 12, kMs = 13;
  if (w[0].size() != kFields || w[1].size() != kFields) {
    differ("STAT", r[0], r[1]);
    return {};
  }
  const bool done = w[0][kDone] == "1" && w[1][kDone] == "1";
  const int apart_ms = std::abs(std::atoi(w[0][kMs].c_str()) - std::atoi(w[1][kMs].c_str()));
  constexpr int kTicks_ms = 20;  // V+ knows times by its slices, and a slip by whole ticks
  if (done && apart_ms > kTicks_ms) differ("a path's time", w[0][kMs], w[1][kMs]);
  std::array<std::string, 2> text;
  for (std::size_t n = 0; n < 2; ++n)
    for (std::size_t k = 0; k < kFields; ++k)
      if (k != kState2 && k != kMs && (done || k != kAt)) text[n] += w[n][k] + ' ';
  differ("STAT", text[0], text[1]);
  return {std::atoi(w[0][kMs].c_str()), std::atoi(w[1][kMs].c_str())};
}

void RobotPair::compare_place() {
  const Replies r = ask("STAT J");
  const std::vector<std::string> a = words_of(r[0]), b = words_of(r[1]);
  if (!same_place_) return;
  bool same = a.size() == 5 && b.size() == 5;
  for (std::size_t n = 1; same && n < 5; ++n)
    same = std::abs(std::atoi(a[n].c_str()) - std::atoi(b[n].c_str())) <= 1;
  if (!same) differ("STAT J", r[0], r[1]);
}

void RobotPair::go_to(const Joints& q) {
  const Replies r = ask("MOVEJ " + fvp::text_of(fvp::nearest_point(q)) + " 100");
  differ("MOVEJ", essence(r[0]), essence(r[1]));
  if (r[0] != "ACK" || r[1] != "ACK") return;
  run_for(4'000'000);
  same_place_ = true;
  compare_events("of a move");
}

void RobotPair::go_anywhere() {
  go_to({(roll(1200) - 600) * 0.1 * kDeg, (roll(1200) + 200) * 0.1 * kDeg, double(roll(200)),
         (roll(3000) - 1500) * 0.1 * kDeg});
}

// Power, calibration, monitor speed 100, nothing held.
void RobotPair::ready() {
  const auto both = [&](const std::string& words) {
    const Replies r = ask(words);
    differ(words, essence(r[0]), essence(r[1]));
    return r[0] == "ACK" && r[1] == "ACK";
  };
  both("CLEAR");
  both("SIG 0");
  both("SPEED 100");
  const std::vector<std::string> w = words_of(ask("STAT")[0]);
  if (w.size() < 7 || w[5] != "1") {
    both("POWER 1");
    run_for(3'200'000);
  }
  if (w.size() < 7 || w[6] != "1") {
    both("CAL");
    some_questions(roll(3));
    run_for(8'500'000);
  }
}

std::string RobotPair::random_command() {
  const auto n = [&](int below) { return std::to_string(roll(below)); };
  switch (roll(22)) {
    case 0:
      return "HB";
    case 1:
      return "STAT J";
    case 2:
      return "SIG " + n(10);
    case 3:
      return "SIG";
    case 4:
      return "SPEED " + n(140);
    case 5:
      return "POWER 2";
    case 6:
      return "MOVEJ 1 2 3";
    case 7:
      return "MOVEJ 2000000 0 100000 0 50";
    case 8:
      return "MOVEZ 300000 50";
    case 9:
      return "MOVEZ 100000 " + std::string(roll(2) ? "0" : "101");
    case 10:
      return "MOVEZ x 50";
    case 11:
      return "FOO " + n(9);
    case 12:
      return "PATH FOO " + n(9);
    case 13:
      return "PATH RUN " + std::to_string(90 + roll(9)) + ' ' + n(9);
    case 14:
      return "PATH RUN 1";
    case 15:
      return "PATH DROP " + n(6);
    case 16:
      return "PATH END " + std::string(roll(2) ? "12G4" : "1234");
    case 17:
      return "PATH P 0 1 2 3 4";
    case 18:
      return "PATH BEGIN " + n(6) + " N=" + n(4) + " DT=0.016";
    case 19:
      return "PATH BEGIN " + n(6) + " N=50 DT=0.0" + n(20);
    case 20:
      return "CLEAR";
    default:
      return "HELLO FIRN 1";
  }
}

void RobotPair::some_questions(int count) {
  for (int k = 0; k < count; ++k) {
    const std::string words = random_command();
    const Replies r = ask(words);
    if (words != "STAT J") differ(words, essence(r[0]), essence(r[1]));
  }
}

// BEGIN, lines of up to three points in blocks of which the last line alone is answered, some of them twice,
// END.
void RobotPair::load(std::int32_t id, const std::vector<Joints>& points) {
  std::vector<fvp::Point> counts;
  for (const Joints& q : points) counts.push_back(fvp::nearest_point(q));
  Replies r = ask("PATH BEGIN " + std::to_string(id) + " N=" + std::to_string(counts.size()) + " DT=0.016");
  differ("PATH BEGIN", essence(r[0]), essence(r[1]));
  for (std::size_t at = 0; at < counts.size();) {
    const std::size_t lines = 1 + std::size_t(roll(6));
    for (std::size_t k = 0; k < lines && at < counts.size(); ++k) {
      const std::size_t here = at;
      std::string words = "PATH P " + std::to_string(here);
      for (std::size_t p = 0; p < 3 && at < counts.size(); ++p) words += ' ' + fvp::text_of(counts[at++]);
      if (k + 1 < lines && at < counts.size()) {
        for (std::size_t n = 0; n < 2; ++n) send(bench_[n], '@' + sealed("0 " + words), n == 1);
        ++counts_.commands;
        if (chance(0.05)) at = here;  // once more: the robot keeps it once
      } else {
        r = ask(words);
        differ("PATH P", essence(r[0]), essence(r[1]));
      }
    }
  }
  r = ask("PATH END " + hex4(fvp::checksum(counts)));
  differ("PATH END", essence(r[0]), essence(r[1]));
}

void RobotPair::load_badly() {
  std::vector<Joints> points(5 + std::size_t(roll(8)), Joints{0.1, 1.0, 50.0, 0.2});
  const int how = roll(4);
  if (how == 0) points[2][1] = 3.0;  // beyond 150 deg
  std::vector<fvp::Point> counts;
  for (const Joints& q : points) counts.push_back(fvp::nearest_point(q));
  const auto both = [&](const std::string& words) {
    const Replies r = ask(words);
    differ(words, essence(r[0]), essence(r[1]));
  };
  both("PATH BEGIN 77 N=" + std::to_string(counts.size() + (how == 1)) + " DT=0.016");
  for (std::size_t at = 0; at < counts.size(); ++at) {
    if (how == 2 && at == 3) both("PATH P 3 1 2");  // cut short: nothing of it is kept
    both("PATH P " + std::to_string(at) + ' ' + fvp::text_of(counts[at]));
  }
  both("PATH END " + hex4(std::uint16_t(fvp::checksum(counts) + (how == 3))));
  if (roll(2)) both("PATH DROP 77");
}

void RobotPair::run_path(bool interrupt) {
  // Straight in joint space and slow enough for every joint, so that a brake stays on it.
  Joints at{(roll(600) - 300) * 0.1 * kDeg, (roll(600) + 400) * 0.1 * kDeg, 40.0 + roll(100),
            (roll(600) - 300) * 0.1 * kDeg};
  Joints step{(roll(80) - 40) * 0.01 * kDeg, (roll(80) - 40) * 0.01 * kDeg, (roll(80) - 40) * 0.01,
              (roll(80) - 40) * 0.01 * kDeg};
  if (!interrupt && roll(2)) step[1] = 0.0;
  const std::size_t count = interrupt ? 200 : 3 + std::size_t(roll(47));
  std::vector<Joints> points;
  for (std::size_t k = 0; k < count; ++k) {
    Joints q;
    const double bend = interrupt ? 0.0 : 0.5 * kDeg * std::sin(0.2 * double(k));
    for (std::size_t n = 0; n < 4; ++n) q[n] = at[n] + step[n] * double(k) + (n == 0 ? bend : 0.0);
    points.push_back(q);
  }
  const int id = 1 + roll(5);
  for (int other = 1; other <= 5; ++other)
    if (other != id && chance(0.8)) ask("PATH DROP " + std::to_string(other));
  load(id, points);
  Joints from = points.front();
  const bool beside = chance(0.15);
  if (beside) from[std::size_t(roll(4))] += 0.1 + 0.01 * roll(10);
  go_to(from);
  const std::string words = "PATH RUN " + std::to_string(id) + ' ' + std::to_string(roll(8));
  if (beside) {
    const Replies r = ask(words);
    return differ(words, essence(r[0]), essence(r[1]));
  }
  ++counts_.paths;
  for (Bench& b : bench_) {
    b.trace.clear();
    b.traced = !interrupt;
  }
  const Replies r = ask(words);
  differ(words, essence(r[0]), essence(r[1]));
  if (r[0] != "ACK" || r[1] != "ACK") {
    for (Bench& b : bench_) b.traced = false;
    return;
  }
  same_place_ = false;
  if (interrupt) return interrupt_motion();
  for (Bench& b : bench_) advance(b, 400'000 + std::int64_t(count) * 16'200);
  for (Bench& b : bench_) b.traced = false;
  compare_events("of a path");
  const std::array<int, 2> took_ms = compare_status();
  ++counts_.paths_through;
  same_place_ = true;
  // One that slips is late in one motion in V+ and all along its way in the other twin: it has no motion in
  // common.
  const int planned_ms = int(count - 1) * 16;
  const auto slipped = [&](int ms) { return ms > planned_ms + 1000 * 0.8 * config_.arm.slip_s; };
  if (config_.arm.slip_probability > 0.0 && (slipped(took_ms[0]) || slipped(took_ms[1]))) {
    ++counts_.slips;
    return differ("a path's slip", slipped(took_ms[0]) ? "yes" : "no", slipped(took_ms[1]) ? "yes" : "no");
  }
  // The trace holds places at which a new sample was seen; both arms step by 4 ms from their motion's start.
  const auto& [a, b] = bench_;
  const std::size_t both = std::min(a.trace.size(), b.trace.size());
  if (a.trace.size() + 2 < b.trace.size() || b.trace.size() + 2 < a.trace.size())
    differ("samples of a path", std::to_string(a.trace.size()), std::to_string(b.trace.size()));
  for (std::size_t back = 1; back <= both; ++back) {  // both end at the path's last point
    const Joints &p = a.trace[a.trace.size() - back], &q = b.trace[b.trace.size() - back];
    ++counts_.samples;
    for (std::size_t n = 0; n < 4; ++n)
      if (std::abs(angle_or_mm(p, n) - angle_or_mm(q, n)) > 1.0)
        return differ("joint " + std::to_string(n + 1) + " of a path, " + std::to_string(back) +
                          " samples before its end",
                      std::to_string(angle_or_mm(p, n)), std::to_string(angle_or_mm(q, n)));
  }
}

// A motion is under way, and takes three seconds.
void RobotPair::interrupt_motion() {
  run_for(200'000 + roll(400'000));
  some_questions(roll(3));
  const int how = roll(6);
  const auto both = [&](const std::string& words) {
    const Replies r = ask(words);
    differ(words, essence(r[0]), essence(r[1]));
  };
  switch (how) {
    case 0:
      both("STOP");
      ++counts_.stops;
      break;
    case 1:
      both("ESTOP");
      ++counts_.stops;
      break;
    case 2:
      ++counts_.silences;
      run_for(1'500'000);  // nothing is said for a second
      break;
    case 3:
    case 4:
      ++counts_.trips;
      for (Bench& b : bench_) b.world.inject({"robot", FaultKind::kTrip, how == 3 ? 1 : 2, 0}, b.now_us);
      break;
    default:
      reconnect();
  }
  run_for(800'000);
  compare_events("of a stop");
  compare_status();
  some_questions(roll(4));
  if (how == 3) {
    both("CLEAR");
    for (Bench& b : bench_) b.world.inject({"robot", FaultKind::kTrip, 0, 0}, b.now_us);
  }
}

void RobotPair::reconnect() {
  ++counts_.reconnects;
  const bool by_robot = roll(4) == 0;
  for (Bench& b : bench_) {
    if (by_robot)
      b.world.inject({"robot", FaultKind::kClose, 1, 0}, b.now_us);
    else
      b.world.disconnect(kRobotPort, b.now_us);
  }
  run_for(roll(2) ? 5'000 : 300'000);
  connect();
}

void RobotPair::reboot() {
  ++counts_.reboots;
  for (Bench& b : bench_) b.world.inject({"robot", FaultKind::kReboot, 1, 0}, b.now_us);
  run_for(5'000'000);
  for (Bench& b : bench_) b.events.clear();
  connect();
  compare_status();
}

void RobotPair::one_turn() {
  ready();
  switch (roll(10)) {
    case 0:
    case 1:
      return some_questions(10);
    case 2:
      return load_badly();
    case 3:
      go_anywhere();
      return compare_place();
    case 4:
    case 5:
      return run_path(false);
    case 6:
    case 7:
      return run_path(true);
    case 8:
      for (int k = 0; k < 3; ++k) {
        reconnect();
        some_questions(1);
      }
      return;
    default:
      if (roll(4) == 0) return reboot();
      compare_status();
  }
}

void RobotPair::run(std::int64_t count) {
  while (counts_.commands < count && differences_.empty()) one_turn();
}

}  // namespace firn::plant
