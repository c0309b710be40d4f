#include "plant/twins/laser_point.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace firn::plant {

using namespace drivers::lkg;

namespace {

constexpr std::int64_t kLeave_us = 600'000, kSelect_us = 200'000;
constexpr int kUnknown = 0, kStatus = 1, kParameter = 22;

std::string error(std::string_view command, int code) {
  const std::string_view name = command.substr(0, std::min<std::size_t>(2, command.size()));
  return "ER," + std::string(name) + "," + (code < 10 ? "0" : "") + std::to_string(code);
}

bool number(std::string_view text, int low, int high, std::int32_t& value) {
  std::int32_t read = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), read);
  if (r.ec != std::errc() || r.ptr != text.data() + text.size() || read < low || read > high) return false;
  value = read;
  return true;
}

std::string value_text(double mm) {
  char text[kValueChars];
  put_value(std::isinf(mm) ? std::copysign(200.0, mm) : mm, text);
  return {text, kValueChars};
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
  return kSampling_us[p.sampling] * 1e-6 * std::pow(4.0, p.averaging);
}
double LaserPointTwin::period_s() const {
  const Program& p = state_.programs[std::size_t(state_.selected)];
  return kSampling_us[p.sampling] * 1e-6 * kCycles[p.cycle] * (1.0 + params_.clock_ppm * 1e-6);
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
  if (command == table_.enter || command == table_.leave) {
    const bool enter = command == table_.enter;
    if (!enter && state_.communication) state_.busy_until_us = now_us + kLeave_us;
    state_.communication = enter;
    return name;
  }
  if (command.starts_with("SW,")) {
    if (!state_.communication) return error(command, kStatus);
    return set(command) ? name.substr(0, 5) : error(command, kParameter);
  }
  if (state_.communication) return error(command, kStatus);
  if (command == table_.measure) {
    const double mm = wires_.nature().read_laser(now_us, settings());
    return name + "," + value_text(mm);
  }
  if (command == table_.selected) return name + "," + std::to_string(state_.selected);
  if (command.starts_with(table_.select + ",")) {
    if (!number(command.substr(table_.select.size() + 1), 0, 7, state_.selected))
      return error(command, kParameter);
    state_.busy_until_us = now_us + kSelect_us;
    return table_.select;
  }
  if (command == table_.clear) {
    state_.storing = 0;
    wires_.nature().end_storage();
    stored_.clear();
    return name;
  }
  if (command == table_.start) {
    stored_.clear();
    state_.storing = 1;
    return name;
  }
  if (command == table_.stop) {
    if (state_.storing && wires_.nature().storage().active) close_storage(now_us);
    state_.storing = 0;
    return name;
  }
  if (command == table_.stored) {
    const Storage& s = wires_.nature().storage();
    const std::size_t values = s.active ? s.mm.size() : stored_.size();
    return name + "," + (state_.storing ? "1," : "0,") + std::to_string(values);
  }
  if (command == table_.dump) {
    std::string all = name;
    all.reserve(name.size() + stored_.size() * 9);
    for (const float mm : stored_) all += "," + value_text(double(mm));
    return all;
  }
  if (command == "VR,1") return "VR";
  if (command.starts_with("KL,")) return "KL";
  return error(command, kUnknown);
}

bool LaserPointTwin::set(std::string_view command) {
  Program& p = state_.programs[std::size_t(state_.selected)];
  const auto after = [&](const std::string& prefix) { return command.substr(prefix.size()); };
  if (command.starts_with(table_.sampling)) return number(after(table_.sampling), 0, 5, p.sampling);
  if (command.starts_with(table_.averaging)) return number(after(table_.averaging), 0, 9, p.averaging);
  if (command.starts_with(table_.material)) return number(after(table_.material), 0, 4, p.material);
  if (!command.starts_with(table_.storage)) return false;
  const std::string_view rest = after(table_.storage);
  const std::size_t comma = rest.find(',');
  return comma != std::string_view::npos && number(rest.substr(0, comma), 1, table_.most_stored, p.most) &&
         number(rest.substr(comma + 1), 0, 9, p.cycle);
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
