#include "plant/twins/laser_point.h"

#include <algorithm>
#include <cmath>

#include "core/options/number.h"

namespace firn::plant {

using namespace lkg;

namespace {

constexpr std::int64_t kLeave_us = 600'000, kSelect_us = 200'000;

bool number(std::string_view text, int low, int high, std::int32_t& value) {
  const std::optional<std::int32_t> read = whole_number(text, low, high);
  value = read.value_or(value);
  return read.has_value();
}

}  // namespace

LaserPointTwin::LaserPointTwin(const IceLaserParams& params, IceWires& wires)
    : Twin(Port::kLaserPoint, TwinLink(10.0e6 / params.baud, 300)), params_(params), wires_(wires) {}

void LaserPointTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    const char c = char(b);
    if (c != '\r') {
      if (line_.size() < 64) line_.push_back(c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c);
      continue;
    }
    const std::string command = std::move(line_);
    line_.clear();
    const std::string answer = execute(command, now_us);
    link_.reply(answer + "\r", std::max(now_us, state_.busy_until_us));
  }
}

// An average over its window has the reading of the window's middle.
double LaserPointTwin::window_s() const {
  const Program& p = state_.programs[std::size_t(state_.selected)];
  return kSampling_us[std::size_t(p.sampling)] * 1e-6 * std::pow(4.0, p.averaging);
}
double LaserPointTwin::period_s() const {
  const Program& p = state_.programs[std::size_t(state_.selected)];
  return kSampling_us[std::size_t(p.sampling)] * 1e-6 * kStoringCycles[std::size_t(p.cycle)] *
         (1.0 + params_.clock_ppm * 1e-6);
}

// Ice lets the beam in: settings for translucent or transparent targets see its surface, those for a plain
// target do not.
LaserSettings LaserPointTwin::settings() const {
  const int m = state_.programs[std::size_t(state_.selected)].material;
  return m == 0 ? LaserSettings::kScaffold : m <= 3 ? LaserSettings::kIce : LaserSettings::kOther;
}

void LaserPointTwin::signal(std::int64_t t_us, bool up) {
  if (!state_.storing) return;
  if (!up) return close_storage(t_us);
  stored_.clear();
  const Program& p = state_.programs[std::size_t(state_.selected)];
  wires_.nature().begin_storage(double(t_us) * 1e-6 + params_.trigger_delay_s - 0.5 * window_s(), period_s(),
                                std::uint32_t(p.most), settings());
}

// Values whose windows were not over are not stored.
void LaserPointTwin::close_storage(std::int64_t now_us) {
  IceNature& nature = wires_.nature();
  const Storage& s = nature.storage();
  if (s.number == 0 || (!s.active && s.mm.empty())) return;
  const double whole = (double(now_us) * 1e-6 - 0.5 * window_s() - s.trigger_s) / s.period_s;
  stored_ = s.mm;
  if (whole < double(stored_.size())) stored_.resize(std::size_t(std::max(0.0, std::floor(whole) + 1.0)));
  nature.end_storage();
}

std::string LaserPointTwin::execute(std::string_view command, std::int64_t now_us) {
  const std::string name(command);
  if (command == "Q0" || command == "R0") {
    const bool enter = command == "Q0";
    if (enter == (state_.communication != 0)) return refused(command, Error::kStatus);  // it is so already
    if (!enter) state_.busy_until_us = now_us + kLeave_us;
    state_.communication = enter;
    return name;
  }
  if (command.starts_with("SW,") || command.starts_with("SR,")) {
    if (!state_.communication) return refused(command, Error::kStatus);
    if (command[1] == 'R') {
      const std::string held = setting(command.substr(3));
      return held.empty() ? refused(command, Error::kParameter) : name + "," + held;
    }
    return set(command) ? name.substr(0, 5) : refused(command, Error::kParameter);
  }
  if (state_.communication) return refused(command, Error::kStatus);
  if (command == "M1") return "M1," + value(wires_.nature().read_laser(now_us, settings()));
  if (command == "M2") return "M2," + value(std::nan(""));  // the second output has no head
  if (command == "M0")
    return "M0," + value(wires_.nature().read_laser(now_us, settings())) + "," + value(std::nan(""));
  if (command == "PR") return "PR," + std::to_string(state_.selected);
  if (command.starts_with("PW,")) {
    if (!number(command.substr(3), 0, kMaxProgram, state_.selected))
      return refused(command, Error::kParameter);
    state_.busy_until_us = now_us + kSelect_us;
    return "PW";
  }
  if (command == "AQ") {
    state_.storing = 0;
    wires_.nature().end_storage();
    stored_.clear();
    return name;
  }
  if (command == "AS") {
    stored_.clear();
    state_.storing = 1;
    return name;
  }
  if (command == "AP") {
    if (state_.storing && wires_.nature().storage().active) close_storage(now_us);
    state_.storing = 0;
    return name;
  }
  if (command == "AN") {  // the second output stores nothing
    const Storage& s = wires_.nature().storage();
    const std::size_t values = s.active ? s.mm.size() : stored_.size();
    return std::string("AN,") + (state_.storing ? "1," : "0,") + std::to_string(values) + ",0";
  }
  if (command == "AO,1") {
    std::string all = "AO";
    all.reserve(all.size() + stored_.size() * 9);
    for (const float mm : stored_) all += ',' + value(double(mm));
    return all;
  }
  if (command == "VR,1" || command == "VR,0") return "VR";
  if (command.starts_with("KL,")) return "KL";
  return refused(command, Error::kCommand);
}

// A set value is written without a point, `+123423`, and told with it, `+12.3423`.
std::string LaserPointTwin::setting(std::string_view identifier) const {
  const Program& p = state_.programs[std::size_t(state_.selected)];
  if (identifier == "HB,1") return std::to_string(p.material);
  if (identifier == "CA") return std::to_string(p.sampling);
  if (identifier == "OF,1") return value(double(p.offset) * 1e-4);
  return {};
}

bool LaserPointTwin::set(std::string_view command) {
  Program& p = state_.programs[std::size_t(state_.selected)];
  constexpr std::string_view kOffset = "SW,OF,1,";
  if (command.starts_with(kOffset)) {
    const std::string_view text = command.substr(kOffset.size());
    std::int32_t v = 0;
    if (text.size() != 7 || (text[0] != '+' && text[0] != '-') || !number(text.substr(1), 0, 999'999, v))
      return false;
    p.offset = text[0] == '-' ? -v : v;
    return true;
  }
  const auto set_by = [&](std::string_view prefix, std::int32_t most, std::int32_t& member) {
    return command.starts_with(prefix) && number(command.substr(prefix.size()), 0, most, member);
  };
  if (set_by("SW,CA,", std::int32_t(kSampling_us.size()) - 1, p.sampling)) return true;
  if (set_by("SW,OC,1,0,", kMaxAveraging, p.averaging)) return true;
  if (set_by("SW,HB,1,", kMaxMaterial, p.material)) return true;
  constexpr std::string_view kStorage = "SW,CI,1,";
  if (!command.starts_with(kStorage)) return false;
  const std::string_view rest = command.substr(kStorage.size());
  const std::size_t comma = rest.find(',');
  return comma != std::string_view::npos && number(rest.substr(0, comma), 1, kMaxStored, p.most) &&
         number(rest.substr(comma + 1), 0, std::int32_t(kStoringCycles.size()) - 1, p.cycle);
}

void LaserPointTwin::trip(std::int64_t, std::int64_t code) {
  wires_.nature().darken_laser(code == 1);
  wires_.nature().stick_laser(code == 2);
}

void LaserPointTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  wires_.nature().end_storage();
  const auto programs = state_.programs;  // kept in the controller's memory
  state_ = State{};
  state_.programs = programs;
  line_.clear();
  stored_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void LaserPointTwin::io(Archive& a) { a.all(boot_count_, state_, line_, stored_, link_); }

}  // namespace firn::plant
