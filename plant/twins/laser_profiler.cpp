#include "plant/twins/laser_profiler.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {
namespace {

constexpr std::uint8_t kErrors = 0x04, kChangeProgram = 0x39, kProfiles = 0x42;
constexpr std::uint8_t kErrorCommand = 0x01, kErrorArgument = 0x03;
constexpr int kUnit = 10;  // z in steps of kUnit x 0.01 um = 0.1 um
constexpr std::int32_t kNoPeak = -524288, kLimit = 524287, kLowest = -524284;
constexpr std::uint32_t kLargestRequest = 4096;
constexpr std::size_t kPosition = 25, kNumber = 28, kCount = 32, kErase = 33;  // of a request for profiles
constexpr double kGauge_mm = 0.5;

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t v = 0;
  for (int n = 3; n >= 0; --n) v = v << 8 | std::uint32_t(bytes[at + std::size_t(n)]);
  return v;
}

void put(std::string& out, std::uint64_t value, int bytes) {
  char text[8];
  for (int n = 0; n < 8; ++n) text[n] = char(value >> 8 * n);
  out.append(text, std::size_t(bytes));
}

}  // namespace

double profile_dx_mm(const GridSpec& grid, const ProfilerParams& params) {
  if (params.dx_mm > 0.0) return params.dx_mm;
  return std::ceil(grid.nx * grid.pitch_x_mm * 1.15 / params.points / 0.005 - 1e-9) * 0.005;
}

double profile_x0_mm(const GridSpec& grid, const ProfilerParams& params) {
  const double centre = grid.origin_x_mm + 0.5 * (grid.nx - 1) * grid.pitch_x_mm;
  return centre - 0.5 * (params.points - 1) * profile_dx_mm(grid, params);
}

ProfilerTwin::ProfilerTwin(const ProfilerParams& params, double x0_mm, double dx_mm)
    : ProfileSensor(Port::kProfiler, TwinLink(0.0, params.latency_us)),
      params_(params),
      x0_mm_(x0_mm),
      dx_mm_(dx_mm) {}

void ProfilerTwin::trigger(std::int64_t t_us, std::int32_t encoder_counts, std::span<const double> z_mm) {
  std::swap(before_, newest_);
  newest_.ready_us = t_us + params_.sampling_us;
  newest_.trigger = ++triggers_;
  newest_.encoder = encoder_counts;
  newest_.points = std::uint32_t(z_mm.size());
  const std::size_t size = z_mm.size();
  units_.resize(size + size % 2);  // a pair of points fills five bytes
  for (std::size_t n = 0; n < size; ++n) {
    const std::size_t at = params_.mirrored ? size - 1 - n : n;
    const double height_mm = z_mm[at] + (gauge_ && at < size / 3 ? kGauge_mm : 0.0);
    const double z = params_.zero_mm + (params_.upside_down ? -height_mm : height_mm);
    const double units = z * (1e5 / kUnit);  // 1 mm = 1e5 x 0.01 um
    units_[n] = std::isnan(units)
                    ? kNoPeak
                    : std::int32_t(std::clamp(units, double(kLowest), double(kLimit)) + 1048576.5) - 1048576;
  }
  if (size % 2 == 1) units_.back() = 0;
  newest_.packed.resize(units_.size() / 2 * 5);
  char* out = newest_.packed.data();
  for (std::size_t n = 0; n < units_.size(); n += 2, out += 5) {
    const std::uint32_t a = std::uint32_t(units_[n]) & 0xfffffu, b = std::uint32_t(units_[n + 1]) & 0xfffffu;
    const std::uint32_t low = a | b << 20;
    for (int k = 0; k < 4; ++k) out[k] = char(low >> 8 * k);
    out[4] = char(b >> 12);
  }
  newest_.packed.resize((size * 20 + 7) / 8);
  memory_.push_back(newest_);
  if (memory_.size() > kMemory) memory_.pop_front();
}

void ProfilerTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  request_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::size_t begin = 0;
  while (request_.size() - begin >= 4) {
    const auto rest = std::as_bytes(std::span(request_).subspan(begin));
    const std::uint32_t following = u32_at(rest, 0);
    if (following < 16 ||
        following > kLargestRequest) {  // not this protocol: the beginning of a frame cannot be found
      request_.clear();
      return;
    }
    if (rest.size() < 4 + std::size_t(following)) break;
    execute(rest.first(4 + following), now_us);
    begin += 4 + following;
  }
  request_.erase(0, begin);
}

void ProfilerTwin::execute(std::span<const std::byte> request, std::int64_t now_us) {
  const auto command = std::uint8_t(request[16]);
  std::uint8_t error = 0;
  std::string body;
  if (command == kChangeProgram) {
    if (request.size() != 24)
      error = kErrorArgument;
    else
      program_ = std::uint8_t(request[20]);
  } else if (command == kErrors) {
    put(body, 0, 4);  // holds none
  } else if (command == kProfiles) {
    if (request.size() != 36 || std::uint8_t(request[kPosition]) > 2)
      error = kErrorArgument;
    else
      body = profiles(request, now_us);
  } else {
    error = kErrorCommand;
  }
  std::string out;
  out.reserve(28 + body.size());
  put(out, 24 + body.size(), 4);  // bytes that follow
  put(out, 0xF0000001, 4);        // a reply; requests have 00F00001
  put(out, 0, 4);                 // header: return code
  put(out, 12 + body.size(), 4);  // bytes from the command on
  put(out, command, 1);
  put(out, error, 1);
  put(out, 0, 6);  // controller status and reserve
  put(out, program_, 4);
  out += body;
  link_.reply(out, now_us);
}

std::string ProfilerTwin::profiles(std::span<const std::byte> request, std::int64_t now_us) {
  const auto position = std::uint8_t(request[kPosition]), most = std::uint8_t(request[kCount]);
  const Shot* newest = newest_.ready_us <= now_us   ? &newest_
                       : before_.ready_us <= now_us ? &before_
                                                    : nullptr;
  const std::uint32_t number = newest ? newest->trigger : 0;
  std::vector<const Shot*> chosen;
  if (position == 0 && newest) chosen.push_back(newest);
  for (const Shot& s : memory_) {
    if (position == 0 || chosen.size() >= most || s.ready_us > now_us) break;
    if (position == 1 || s.trigger - u32_at(request, kNumber) < kMemory) chosen.push_back(&s);
  }
  std::string body;
  body.reserve(36 + chosen.size() * (chosen.empty() ? 0 : chosen[0]->packed.size() + 32));
  put(body, number, 4);
  put(body, memory_.empty() ? number : memory_.front().trigger, 4);
  put(body, chosen.empty() ? number : chosen[0]->trigger, 4);
  put(body, chosen.size(), 1);
  put(body, 0, 7);
  put(body, chosen.empty() ? 0 : 1, 4);
  if (chosen.empty()) return body;
  const double first_mm = x0_mm_ - params_.head_x_mm;
  const double last_mm = first_mm + double(chosen[0]->points - 1) * dx_mm_;
  put(body, chosen[0]->points, 2);
  put(body, kUnit, 2);
  put(body, std::uint32_t(std::int32_t(std::llround((params_.mirrored ? -last_mm : first_mm) * 1e5))), 4);
  put(body, std::uint32_t(std::int32_t(std::llround(dx_mm_ * 1e5))), 4);
  for (const Shot* s : chosen) {
    put(body, 0, 4);
    put(body, s->trigger, 4);
    put(body, std::uint32_t(s->encoder), 4);
    put(body, 0, 8);
    put(body, 0, 4);
    body += s->packed;
    body.append((4 - s->packed.size() % 4) % 4, '\0');
    put(body, 0, 4);  // ends the profile
  }
  if (std::uint8_t(request[kErase]) == 1) {
    const std::uint32_t last = chosen.back()->trigger;
    while (!memory_.empty() && last - memory_.front().trigger < kMemory) memory_.pop_front();
  }
  return body;
}

void ProfilerTwin::reboot(std::int64_t) {
  ++boot_count_;
  request_.clear();
  program_ = 0;
  triggers_ = 0;
  newest_ = before_ = {};
  memory_.clear();
}

void ProfilerTwin::io(Archive& a) {
  a.all(boot_count_, request_, program_, triggers_, gauge_, newest_, before_, memory_, link_);
}

}  // namespace firn::plant
