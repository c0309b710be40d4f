// Robot: orders of a person, beside a print (firn device).
#include <cmath>
#include <cstdio>
#include <numbers>

#include "drivers/robot/robot.h"

namespace firn::drivers {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kJog = 5.0;  // deg, or mm of J3
constexpr int kJogPercent = 1, kMostLines = 1000;

std::string_view reply_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

void Robot::jog(std::span<const double> v, std::int64_t now_us, Effects& fx) {
  if (!where_) return refuse(kUnreachable, "where the robot stands is not known", fx);
  fvp::Joints to = fvp::joints_of(*where_);
  const auto joint = std::size_t(v[0]) - 1;
  to[joint] += joint == 2 ? v[1] : v[1] * kRadians;
  move_to(to, kJogPercent, now_us, fx);
}

void Robot::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  const auto asked = [this](std::string_view question) {
    LineWriter line = fvp::request(seq(), question);
    return fvp::to_request(line, seq_, Repeat::kRead, kServiceTag);
  };
  Service s{std::string(verb), {}, 0, {}, nullptr};
  if (verb == "lines" && v.size() == 1) {
    if (!whole_within(v[0], 1, kMostLines))
      return refuse(kLimit, "lines are a whole number, 1 to " + std::to_string(kMostLines), fx);
    for (int n = 0; n < int(v[0]); ++n) s.begin.push_back(asked("STAT"));
    s.tell = [](const Request&, std::span<const std::byte> frame) -> std::optional<std::string> {
      WordReader words(fvp::parse(reply_text(frame)).text);
      return words.word() == "ACK" ? std::optional<std::string>("") : std::nullopt;
    };
    s.then = [n = v[0], begun_us = now_us](std::int64_t now, Effects& effects) {
      char text[80];
      const double took_s = double(now - begun_us) * 1e-6;
      std::snprintf(text, sizeof text, "%.0f lines in %.3f s: %.0f a second", n, took_s, n / took_s);
      effects.events.emplace_back(
          Result{Outcome::kDone, std::int64_t(n), std::int64_t(n), 0, 0, kNoCode, text});
    };
    return run_service(std::move(s));
  }
  if (verb != "where" && verb != "jog") return Driver::service(verb, v, now_us, fx);
  s.begin = {asked("STAT J")};
  s.tell = [this](const Request&, std::span<const std::byte> frame) -> std::optional<std::string> {
    WordReader words(fvp::parse(reply_text(frame)).text);
    if (words.word() != "ACK") return std::nullopt;
    const auto counts = fvp::parse_counts(words);
    if (!counts) return std::nullopt;
    where_ = *counts;
    const fvp::Joints j = fvp::joints_of(*counts);
    char text[100];
    std::snprintf(text, sizeof text, "J1 %.4f deg, J2 %.4f deg, J3 %.3f mm, J4 %.4f deg", j[0] / kRadians,
                  j[1] / kRadians, j[2], j[3] / kRadians);
    return text;
  };
  if (verb == "jog") {
    if (v.size() != 3 || !whole_within(v[0], 1, 4)) return refuse(kLimit, "a jog is of joint 1 to 4", fx);
    if (v[2] == 0.0 && !(std::abs(v[1]) <= kJog))
      return refuse(kLimit, "a jog is at most 5 deg or 5 mm; --far allows more", fx);
    s.then = [this, joint = v[0], by = v[1]](std::int64_t now, Effects& effects) {
      jog(std::array{joint, by}, now, effects);
    };
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
