#include "tests/drivers/bench.h"

#include <catch2/catch.hpp>
#include <cctype>
#include <fstream>

#include "drivers/heater/heater.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/laser_profiler/laser_profiler.h"

namespace firn::drivers::test {

void Bench::step(const std::function<void(Effects&)>& f) {
  fx_.clear();
  f(fx_);
  for (const std::byte b : fx_.tx) tx += char(b);
  for (DriverEvent& e : fx_.events) events.push_back(std::move(e));
  reopens += fx_.reopen;
  wake_us_ = fx_.wake_us;
}

void Bench::feed(std::string_view bytes) {
  const std::size_t piece = split == 0 ? bytes.size() : split;
  for (std::size_t n = 0; n < bytes.size(); n += piece) {
    const std::string_view part = bytes.substr(n, piece);
    step([&](Effects& fx) {
      driver_.received(std::as_bytes(std::span(part.data(), part.size())), now_us, fx);
    });
  }
}

bool Bench::advance_to_wake() {
  if (wake_us_ == 0) return false;
  now_us = std::max(now_us, wake_us_);
  step([&](Effects& fx) { driver_.woke(now_us, fx); });
  return true;
}

void Bench::advance_us(std::int64_t by) {
  const std::int64_t end = now_us + by;
  while (wake_us_ != 0 && wake_us_ <= end) {
    const std::int64_t before = wake_us_;
    advance_to_wake();
    REQUIRE((wake_us_ == 0 || wake_us_ > before || wake_us_ > now_us));  // a wake in the past would spin
  }
  now_us = end;
}

std::string Bench::take_line() {
  const std::size_t end = tx.find_first_of("\r\n");
  if (end == std::string::npos) return {};
  std::string line = tx.substr(0, end + 1);
  tx.erase(0, end + 1);
  return line;
}

std::string describe(const DriverEvent& event) {
  struct Visitor {
    std::string operator()(const StateChange& s) const {
      return std::string("state ") + name(s.state) + ": " + s.text;
    }
    std::string operator()(const Result& r) const {
      std::string text = std::string("result ") + name(r.outcome) + " " + std::to_string(r.counted) + "/" +
                         std::to_string(r.expected);
      if (r.unknown_from != r.unknown_to)
        text += " unknown [" + std::to_string(r.unknown_from) + "," + std::to_string(r.unknown_to) + ")";
      return text + " code " + std::to_string(r.code) + ": " + r.text;
    }
    std::string operator()(const Progress& p) const {
      return "progress " + std::to_string(p.rows_done) + "/" + std::to_string(p.rows) + " " +
             std::to_string(p.counted);
    }
    std::string operator()(const Fault& f) const {
      return "fault " + std::to_string(int(f.severity)) + " code " + std::to_string(f.code) + ": " + f.text;
    }
    std::string operator()(const Measured& m) const {
      if (const auto* row = std::any_cast<ProfileRow>(&m.value)) return (*this)(*row);
      if (const auto* done = std::any_cast<ScanDone>(&m.value)) return (*this)(*done);
      if (const auto* samples = std::any_cast<Samples>(&m.value)) return (*this)(*samples);
      if (const auto* temperatures = std::any_cast<Temperatures>(&m.value)) return (*this)(*temperatures);
      return "measured";
    }
    std::string operator()(const ProfileRow& p) const {
      return "profile row " + std::to_string(p.row) + " points " + std::to_string(p.z_mm.size()) +
             " trigger " + std::to_string(p.trigger_count) + " encoder " + std::to_string(p.encoder_count);
    }
    std::string operator()(const ScanDone& d) const {
      return "scan done " + std::to_string(d.rows_received) + "/" + std::to_string(d.rows_expected);
    }
    std::string operator()(const Samples& s) const {
      return "samples " + std::to_string(s.z_mm.size()) + "/" + std::to_string(s.expected) + " material " +
             std::to_string(s.material) + " damaged " + std::to_string(s.damaged);
    }
    std::string operator()(const Temperatures& t) const {
      std::string text = "temperatures";
      for (std::size_t c = 0; c < 3; ++c)
        text +=
            " " + std::to_string(t.celsius[c]) + (t.fault[c] ? "!" + std::to_string(int(t.fault[c])) : "");
      return text;
    }
  };
  return std::visit(Visitor{}, event);
}

std::string hex(std::string_view bytes) {
  std::string out;
  for (const char c : bytes) {
    char text[4];
    std::snprintf(text, sizeof text, "%02X ", unsigned(static_cast<unsigned char>(c)));
    out += text;
  }
  if (!out.empty()) out.pop_back();
  return out;
}

std::string unhex(std::string_view text) {
  std::string out;
  for (std::size_t n = 0; n < text.size();) {
    if (std::isspace(static_cast<unsigned char>(text[n]))) {
      ++n;
      continue;
    }
    out += char(std::stoi(std::string(text.substr(n, 2)), nullptr, 16));
    n += 2;
  }
  return out;
}

namespace {

std::string unescape(std::string_view text) {
  std::string out;
  for (std::size_t n = 0; n < text.size(); ++n) {
    if (text[n] != '\\' || n + 1 == text.size()) {
      out += text[n];
      continue;
    }
    ++n;
    out += text[n] == 'n' ? '\n' : text[n] == 'r' ? '\r' : text[n];
  }
  return out;
}

}  // namespace

void play(Driver& driver, const std::string& path,
          const std::function<void(const std::string&, std::int64_t, Effects&)>& command, std::size_t split) {
  std::ifstream file(path);
  INFO(path);
  REQUIRE(file);
  Bench bench(driver);
  bench.split = split;
  bench.open();
  bool binary = false;
  std::size_t next_event = 0;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    INFO("line " << number << ": " << line);
    if (line == "hex") {
      binary = true;
      continue;
    }
    const std::string rest = line.size() > 2 ? line.substr(2) : std::string();
    const std::string bytes =
        line[0] == '>' || line[0] == '<' ? (binary ? unhex(rest) : unescape(rest)) : std::string();
    if (line[0] == '>') {
      for (int n = 0; bench.tx.empty() && n < 1000; ++n) REQUIRE(bench.advance_to_wake());
      const std::string sent = bench.tx.substr(0, bytes.size());
      INFO("sent " << (binary ? hex(bench.tx) : bench.tx));
      REQUIRE(sent == bytes);
      bench.tx.erase(0, bytes.size());
      continue;
    }
    INFO("sent and not in the transcript: " << (binary ? hex(bench.tx) : bench.tx));
    REQUIRE(bench.tx.empty());
    if (line[0] == '<') {
      bench.feed(bytes);
    } else if (line[0] == '~') {
      bench.advance_us(std::stoll(line.substr(1)) * 1000);
    } else if (line[0] == '=') {
      bench.command([&](std::int64_t now_us, Effects& fx) { command(rest, now_us, fx); });
    } else if (line[0] == '*') {
      bool found = false;
      std::string seen;
      while (next_event < bench.events.size() && !found) {
        const std::string text = describe(bench.events[next_event++]);
        seen += "\n  " + text;
        found = text.find(rest) != std::string::npos;
      }
      INFO("events:" << seen);
      REQUIRE(found);
    } else {
      FAIL("unknown transcript line");
    }
  }
  INFO("sent after the transcript: " << (binary ? hex(bench.tx) : bench.tx));
  REQUIRE(bench.tx.empty());
}

}  // namespace firn::drivers::test
