#include "drivers/stage/stage_service.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "drivers/link/service.h"

namespace firn::drivers {

using ensemble::Line;

namespace {

constexpr double kJog_mm = 5.0;
constexpr int kMaxPulses = 1000;

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
std::vector<Request> service_questions(std::string_view verb, const ensemble::Table& table) {
  std::vector<Request> questions;
  const auto ask = [&](Line& line, int argument) {
    Request r = line.done();
    r.argument = argument;
    questions.push_back(r);
  };
  if (verb == "serial") {
    Line line(table, Repeat::kRead, kServiceTag, ensemble::kText);
    ask(line.text("VERSION"), 0);
    return questions;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (verb != "params") {
      Line line(table, Repeat::kRead, kServiceTag, ensemble::kValue);
      ask(line.text("PFBKPROG(").axis(axis).text(")"), axis);
      continue;
    }
    int place = 0;
    for (const Asked& a : kAxisParameters) {
      Line line(table, Repeat::kRead, kServiceTag, ensemble::kValue);
      ask(line.text("GETPARM(").axis(axis).text(", ").integer(a.parameter).text(")"), 4 * ++place + axis);
    }
  }
  return questions;
}

std::string service_answer(const Request& request, const ensemble::Reply& r, const std::string& identity) {
  if (request.format == ensemble::kText) return identity + " version " + std::string(r.value);
  const auto axis = std::size_t(request.argument % 4), place = std::size_t(request.argument / 4);
  const double value = r.number().value_or(std::numeric_limits<double>::quiet_NaN());
  const std::string name(1, "xyz"[axis]);
  return shown((place == 0 ? name : name + " " + kAxisParameters[place - 1].name).c_str(), value);
}

std::optional<std::size_t> asked_place(const Request& question) {
  if (question.format == ensemble::kText || question.argument / 4 != 0) return std::nullopt;
  return std::size_t(question.argument % 4);
}

std::optional<std::string> jog_refused(std::span<const double> v) {
  const bool far = v[4] != 0.0;
  for (int axis = 0; axis < 3; ++axis)
    if (const double by = v[std::size_t(axis)]; !far && !(std::abs(by) <= kJog_mm))
      return shown((std::string("a jog of ") + "xyz"[axis] + " by").c_str(), by) +
             " mm is beyond 5 mm; --far allows it";
  if (!(v[3] > 0.0) || (!far && v[3] > kStageJogSpeed_mm_s))
    return shown("a jog at", v[3]) + " mm/s is outside (0, 10] mm/s; --far allows it";
  return std::nullopt;
}

std::optional<std::string> pulses_refused(std::span<const double> v) {
  if (!(v[0] >= 1 && v[0] <= kMaxPulses) || v[0] != std::floor(v[0]))
    return "pulses are a whole number, 1 to " + std::to_string(kMaxPulses);
  if (!(v[1] > 0.0) || v[0] * v[1] > 10.0 * kJog_mm)
    return "pulses over " + shown("", v[0] * v[1]) + " mm are outside (0, 50] mm";
  return std::nullopt;
}

}  // namespace firn::drivers
