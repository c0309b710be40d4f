// Stage: orders of a person, beside a print (firn device).
#include <cmath>
#include <cstdio>

#include "drivers/stage/stage.h"

namespace firn::drivers {

using ensemble::Line;

namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kJog_mm = 5.0, kJogSpeed_mm_s = 10.0;
constexpr double kPulseRate_hz = 100.0;
constexpr int kMostPulses = 1000;

struct Asked {
  ensemble::Parameter parameter;
  const char* name;
};
constexpr Asked kAxisParameters[] = {{ensemble::kCountsPerUnit, "counts per unit"},
                                     {ensemble::kSoftwareLimitLow, "low limit"},
                                     {ensemble::kSoftwareLimitHigh, "high limit"},
                                     {ensemble::kSoftwareLimitSetup, "limit setup"}};

std::string shown(const char* name, double value) {
  char text[60];
  std::snprintf(text, sizeof text, "%s %.4f", name, value);
  return text;
}

}  // namespace

// Request::argument: the axis, and for parameters 4 (1 + place in kAxisParameters) + axis.
void Stage::ask_service(std::string_view verb, Service& s) {
  const auto ask = [&](Line& line, int argument) {
    Request r = line.done();
    r.argument = argument;
    s.begin.push_back(r);
  };
  if (verb == "serial") {
    Line line(config_.table, Repeat::kRead, kServiceTag, ensemble::kText);
    return ask(line.text("VERSION"), 0);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (verb != "params") {
      Line line(config_.table, Repeat::kRead, kServiceTag, ensemble::kValue);
      ask(line.text("PFBKPROG(").axis(axis).text(")"), axis);
      continue;
    }
    int place = 0;
    for (const Asked& a : kAxisParameters) {
      Line line(config_.table, Repeat::kRead, kServiceTag, ensemble::kValue);
      ask(line.text("GETPARM(").axis(axis).text(", ").integer(a.parameter).text(")"), 4 * ++place + axis);
    }
  }
}

void Stage::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  Service s{std::string(verb),
            {},
            0,
            {},
            [this](const Request& request, std::span<const std::byte> frame) -> std::optional<std::string> {
              const ensemble::Reply r = dialect_.parse(frame);
              if (r.kind != ensemble::Reply::Kind::kOk) return std::nullopt;
              if (request.format == ensemble::kText) return identity_ + " version " + std::string(r.value);
              const auto axis = std::size_t(request.argument % 4), place = std::size_t(request.argument / 4);
              const double value = r.number().value_or(kNoNumber);
              if (place == 0) position_mm_[axis] = value;
              const std::string name(1, "xyz"[axis]);
              return shown((place == 0 ? name : name + " " + kAxisParameters[place - 1].name).c_str(), value);
            }};
  if (verb == "jog" && v.size() == 5) {
    const bool far = v[4] != 0.0;
    for (int axis = 0; axis < 3; ++axis)
      if (const double by = v[std::size_t(axis)]; !far && !(std::abs(by) <= kJog_mm))
        return refuse(kLimit,
                      shown((std::string("a jog of ") + "xyz"[axis] + " by").c_str(), by) +
                          " mm is beyond 5 mm; --far allows it",
                      fx);
    if (!(v[3] > 0.0) || (!far && v[3] > kJogSpeed_mm_s))
      return refuse(kLimit, shown("a jog at", v[3]) + " mm/s is outside (0, 10] mm/s; --far allows it", fx);
    ask_service(verb, s);
    s.then = [this, by = std::array{v[0], v[1], v[2]}, speed = v[3]](std::int64_t now, Effects& effects) {
      std::array<double, 3> to{kNoNumber, kNoNumber, kNoNumber};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (by[axis] != 0.0) to[axis] = position_mm_[axis] + by[axis];
      begin_move(to[0], to[1], to[2], speed, now, effects);
    };
  } else if (verb == "pulse" && v.size() == 2) {
    if (!(v[0] >= 1 && v[0] <= kMostPulses) || v[0] != std::floor(v[0]))
      return refuse(kLimit, "pulses are a whole number, 1 to " + std::to_string(kMostPulses), fx);
    if (!(v[1] > 0.0) || v[0] * v[1] > 10.0 * kJog_mm)
      return refuse(kLimit, "pulses over " + shown("", v[0] * v[1]) + " mm are outside (0, 50] mm", fx);
    ask_service(verb, s);
    s.then = [this, n = int(v[0]), pitch = v[1]](std::int64_t now, Effects& effects) {
      for (std::size_t axis = 0; axis < 2; ++axis)  // a row is planned for a place that can be
        if (auto why = limit_broken("XY"[axis], position_mm_[axis], limits_[axis]))
          return refuse(kLimit, *why, effects);
      GridSpec row;
      row.nx = n;
      row.ny = 1;
      row.pitch_x_mm = row.pitch_y_mm = pitch;
      row.origin_x_mm = position_mm_[0] + pitch;
      row.origin_y_mm = position_mm_[1];
      begin_pass(DropletPattern(row, 1), 0, kNoNumber, std::min(kJogSpeed_mm_s, pitch * kPulseRate_hz), 0.0,
                 now, effects);
    };
  } else if ((verb == "where" || verb == "params" || verb == "serial") && v.empty()) {
    ask_service(verb, s);
  } else {
    return Driver::service(verb, v, now_us, fx);
  }
  run_service(std::move(s));
}

}  // namespace firn::drivers
