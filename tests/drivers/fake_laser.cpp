#include "tests/drivers/fake_laser.h"

#include <utility>

#include "drivers/laser_point/lkg.h"
#include "tests/support/laser_values.h"

namespace firn::drivers::test {
namespace {

std::string value(double mm) {
  char text[lkg::kValueChars];
  lkg::put_value(mm, text);
  return {text, sizeof text};
}

}  // namespace

void FakeLaser::reboot() {
  communication = armed = false;
  stored = 0;
  trigger_us_ = 0;
  surface = sampling = averaging = cycle = -1;
}

void FakeLaser::count(std::int64_t now_us) {
  if (trigger_us_ == 0) return;
  const std::int64_t period_us =
      cycle < 0 ? 10'000 : std::int64_t(lkg::kSampling_us[sampling]) * lkg::kCycles[cycle];
  stored = std::min(heights.size(), std::size_t((now_us - trigger_us_) / period_us) + 1);
}

void FakeLaser::advance(std::int64_t now_us) {
  if (pending_us_ == 0 || now_us < pending_us_) return;
  pending_us_ = 0;
  out += std::exchange(pending_, {});
}

void FakeLaser::take(std::string_view bytes, std::int64_t now_us) {
  advance(now_us);
  for (const char c : bytes) {
    if (c != '\r') {
      line_ += c;
      continue;
    }
    const std::string command = std::exchange(line_, {});
    commands.push_back(command);
    std::string reply = execute(command, now_us) + "\r";
    if (refuse_next >= 0) {
      const int e = std::exchange(refuse_next, -1);
      reply = "ER," + command.substr(0, 2) + "," + char('0' + e / 10) + char('0' + e % 10) + "\r";
    }
    if (timing_before_reply) reply = "TG,1,+09.9999\r" + reply;
    pending_ += reply;
    pending_us_ = now_us + std::int64_t(double(pending_.size()) * 86.8);
  }
}

std::string FakeLaser::execute(std::string_view c, std::int64_t now_us) {
  const std::string verb(c.substr(0, 2));
  if (verb == "R0" || verb == "Q0") {
    const bool enter = verb == "Q0";
    if (communication == enter) return "ER," + verb + ",01";
    communication = enter;
    return verb;
  }
  if (verb == "SW") {
    if (!communication) return "ER,SW,01";
    const int last = c.back() - '0';
    if (c.starts_with("SW,CA,")) sampling = last;
    if (c.starts_with("SW,OC,")) averaging = last;
    if (c.starts_with("SW,HB,")) surface = last;
    if (c.starts_with("SW,CI,")) cycle = last;
    return std::string(c.substr(0, 5));
  }
  if (communication) return "ER," + verb + ",01";
  if (verb == "PW") return program = c.back() - '0', "PW";
  if (verb == "PR") return "PR," + std::to_string(program);
  if (verb == "M1") return "M1," + value(now_mm);
  if (verb == "AQ") return stored = 0, trigger_us_ = 0, armed = false, "AQ";
  if (verb == "AS") return armed = true, "AS";
  if (verb == "AP") {
    count(now_us);
    trigger_us_ = 0;
    armed = false;
    return "AP";
  }
  if (verb == "AN") return "AN," + std::to_string(int(armed)) + "," + std::to_string(stored);
  if (verb != "AO") return "ER," + verb + ",00";
  std::string all = "AO,1";
  for (std::size_t n = 0; n < stored; ++n) all += "," + value(heights[n]);
  return all;
}

}  // namespace firn::drivers::test
