#include "tests/drivers/fake_robot.h"

#include <utility>

#include "drivers/link/crc16.h"

namespace firn::drivers::test {

using fvp::State;

void FakeRobot::settle() {
  bool ready = false;
  std::size_t slot = 0;
  status.held = {0, 0};
  for (const auto& [id, p] : stored_)
    if (p.complete) {
      ready = true;
      if (slot < status.held.size()) status.held[slot++] = std::int32_t(id);
    }
  if (status.state == State::kHold || status.state == State::kFault || status.state == State::kEstop) return;
  status.state = moving || status.running     ? State::kRunning
                 : loading_                   ? State::kLoading
                 : ready && status.calibrated ? State::kReady
                                              : State::kIdle;
  status.state2 = status.state == State::kRunning ? 1 : 2;
}

void FakeRobot::reboot() {
  ++status.boot_count;
  stored_.clear();
  loading_ = last_seq_ = 0;
  moving = false;
  status.running = status.last = 0;
  status.at = 0;
  status.power = status.calibrated = status.last_done = false;
  status.state = State::kIdle;
  signals = 0;
  settle();
}

void FakeRobot::end_motion(bool done, std::int64_t now_us) {
  signals = 0;
  if (status.running) {
    const Stored& p = stored_.at(status.running);
    const auto passed = std::min<std::int64_t>(std::int64_t(p.n), 1 + (now_us - start_us_) / 16'000);
    status.at = done ? int(p.n) : int(passed);
    status.last = status.running;
    status.last_done = done;
    status.last_ms = std::int32_t((now_us - start_us_) / 1000);
    runs.back().finished = done;
    at = p.points[std::size_t(status.at - 1)];
  } else if (done) {
    at = target_;
  }
  const bool was_path = status.running != 0;
  status.running = 0;
  moving = false;
  settle();
  if (!done || silent_events) return;
  LineWriter line = fvp::event(++events_, was_path ? "PATH_DONE" : "MOVE_DONE");
  if (was_path) line.word(status.last).word(status.last_ms);
  fvp::put(line, at);
  out += line.finish(1);
}

void FakeRobot::advance(std::int64_t now_us) {
  if ((moving || status.running) && now_us >= end_us) end_motion(true, end_us);
}

void FakeRobot::take(std::string_view bytes, std::int64_t now_us) {
  advance(now_us);
  for (const char c : bytes) {
    line_ += c;
    if (c != '\n') continue;
    const std::string line = std::exchange(line_, {});
    const fvp::Message m = fvp::parse(line);
    if (m.kind != fvp::Message::Kind::kNumbered) continue;
    const bool hello = m.text.starts_with("HELLO");
    if (m.seq != 0 && !hello && m.seq == last_seq_) {
      ++repeated;
      out += last_reply_;
      continue;
    }
    std::string reply;
    if (m.seq != 0 && !hello && !fvp::newer(m.seq, last_seq_)) {
      reply = "NAK 11 old";
    } else {
      if (m.seq != 0) requests.emplace_back(m.text);
      reply = execute(WordReader(m.text), now_us);
      if (m.seq != 0) last_seq_ = m.seq;
    }
    if (m.seq == 0) continue;
    LineWriter w = fvp::request(m.seq, reply);
    last_reply_ = w.finish(1);
    out += last_reply_;
    ++answered;
  }
}

std::string FakeRobot::execute(WordReader words, std::int64_t now_us) {
  const std::string_view verb = words.word();
  if (verb == "HELLO") return "ACK OK C40 1 TICK=0.016";
  if (verb == "STAT") {
    LineWriter w;
    w.text("ACK");
    words.at_end() ? fvp::put(w, status) : fvp::put(w, at);
    return std::string(w.so_far());
  }
  if (verb == "HB") return "ACK " + std::string(fvp::name(status.state));
  if (verb == "SPEED") return "ACK " + std::to_string(status.speed_percent = int(words.number(1, 100)));
  if (verb == "CLEAR") {
    if (pressed) return "NAK 20 fatal error, or the emergency stop is pressed";
    status.state = State::kIdle;
    status.error = 0;
    settle();
    return "ACK";
  }
  if (verb == "SIG") return signals = int(words.number(0, 7)), "ACK 0";
  if (verb == "STOP" || verb == "ESTOP") {
    if (moving || status.running) {
      status.state = State::kHold;
      end_motion(false, now_us);
    }
    return "ACK";
  }
  if (verb == "POWER") return status.power = true, "ACK";
  if (verb == "CAL") {
    if (!status.power) return "NAK 24 no power";
    status.calibrated = true;
    settle();
    return "ACK";
  }
  if (verb == "PATH") return path(words, now_us);
  if (verb == "MOVEJ" || verb == "MOVEZ") {
    if (!status.calibrated) return "NAK 23 not calibrated";
    if (moving || status.running || status.state == State::kHold) return "NAK 20 state";
    target_ = at;
    if (verb == "MOVEZ")
      target_[2] = std::int32_t(words.number(0, 210'000));
    else
      target_ = fvp::parse_counts(words).value();
    moving = true;
    ++moves;
    end_us = now_us + move_us;
    settle();
    return "ACK";
  }
  return "NAK 21 verb";
}

std::string FakeRobot::path(WordReader words, std::int64_t now_us) {
  const std::string_view verb = words.word();
  if (verb == "BEGIN") {
    const std::int64_t id = words.number(1, fvp::kMaxId);
    const std::string_view n = words.word();
    stored_.erase(id);
    if (loading_ != 0 && !stored_[loading_].complete) stored_.erase(loading_);
    if (stored_.size() >= 2) return "NAK 20 no slot";
    stored_[id].n = std::size_t(std::stoll(std::string(n.substr(2))));
    loading_ = id;
    settle();
    return "ACK 1";
  }
  if (verb == "P" && loading_) {
    Stored& p = stored_[loading_];
    const auto first = std::size_t(words.number(0, fvp::kMaxPoints));
    if (first == p.points.size()) {
      p.crc.add(words.rest().substr(1));
      while (!words.at_end()) p.points.push_back(fvp::parse_counts(words).value());
    }
    return "ACK " + std::to_string(p.points.size());
  }
  if (verb == "END" && loading_) {
    Stored& p = stored_[loading_];
    if (p.points.size() != p.n || hex4(words.word()) != int(p.crc.value())) return "NAK 10 crc";
    p.complete = true;
    loading_ = 0;
    settle();
    return "ACK " + std::to_string(p.n);
  }
  const std::int64_t id = words.number(1, fvp::kMaxId);
  if (verb == "DROP") {
    stored_.erase(id);
    if (loading_ == id) loading_ = 0;
    settle();
    return "ACK";
  }
  if (verb != "RUN") return "NAK 20 state";
  if (moving || status.running || status.state == State::kHold) return "NAK 20 state";
  const auto found = stored_.find(id);
  if (found == stored_.end() || !found->second.complete) return "NAK 20 no such path";
  if (status.speed_percent != 100) return "NAK 30 speed";
  for (std::size_t j = 0; j < 4; ++j)
    if (std::abs(found->second.points.front()[j] - at[j]) > 700) return "NAK 22 not at its start";
  signals = int(words.number(0, 7));
  status.running = std::int32_t(id);
  status.at = 1;
  runs.push_back({found->second.points, signals, false});
  start_us_ = now_us;
  end_us = now_us + std::int64_t(found->second.n - 1) * 16'000 + slip_us;
  settle();
  return "ACK";
}

}  // namespace firn::drivers::test
