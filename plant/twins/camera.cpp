#include "plant/twins/camera.h"

#include "core/options/number.h"

namespace firn::plant {
namespace {

constexpr std::size_t kLongestOrder = 120;
constexpr double kMaxExposure_us = 1e7, kMaxGain_db = 48.0, kMaxDelay_us = 2e9;

std::string_view next_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const std::string_view word = text.substr(0, text.find(' '));
  text.remove_prefix(word.size());
  return word;
}

template <class T>
bool read(std::string_view& text, T low, T high, T& value) {
  const std::optional<T> read = whole_number(next_word(text), low, high);
  value = read.value_or(value);
  return read.has_value();
}

std::string pixel_bytes(const TakenPicture& p) {
  std::string out;
  const bool wide = p.white > 255;
  out.reserve(p.pixels.size() * (wide ? 2 : 1));
  for (const std::uint16_t v : p.pixels) {
    out.push_back(char(v & 0xFF));
    if (wide) out.push_back(char(v >> 8));
  }
  return out;
}

std::uint32_t fletcher(std::string_view bytes) {
  std::uint32_t a = 0, b = 0;
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    const std::uint32_t low = std::uint8_t(bytes[i]),
                        high = i + 1 < bytes.size() ? std::uint8_t(bytes[i + 1]) : 0u;
    a = (a + (high << 8 | low)) % 65535;
    b = (b + a) % 65535;
  }
  return b << 16 | a;
}

}  // namespace

CameraTwin::CameraTwin(const CameraParams& params, Scene scene)
    : Twin(Port::kCamera, TwinLink(0.0, params.latency_us)), params_(params), scene_(std::move(scene)) {}

void CameraTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    const char c = char(b);
    if (c != '\n') {
      if (line_.size() < kLongestOrder) line_.push_back(c);
      continue;
    }
    const std::string line = std::move(line_);
    line_.clear();
    std::string reply = execute(line, now_us);
    const bool picture = reply.starts_with("OK SNAP");
    link_.reply(reply, picture ? now_us + std::int64_t(settings_.exposure_us) + params_.readout_us : now_us);
  }
}

std::string CameraTwin::execute(std::string_view line, std::int64_t now_us) {
  std::string_view rest = line;
  const std::string_view verb = next_word(rest);
  if (verb == "ID") return "OK ID " + params_.name + "\n";
  if (verb == "SET") {
    Exposure wanted = settings_;
    if (!read(rest, 1.0, kMaxExposure_us, wanted.exposure_us))
      return "NO SET exposure is outside [1, 1e7] us\n";
    if (!read(rest, -kMaxGain_db, kMaxGain_db, wanted.gain_db))
      return "NO SET gain is outside [-48, 48] dB\n";
    if (!read(rest, 0.0, kMaxDelay_us, wanted.delay_us)) return "NO SET delay is outside [0, 2e9] us\n";
    settings_ = wanted;
    return "OK SET\n";
  }
  std::int64_t number = 0;
  if (verb == "SNAP" && read(rest, std::int64_t(0), std::int64_t(INT32_MAX), number))
    return trip_ == 1 ? "NO SNAP the sensor is disconnected\n" : snap(number, now_us);
  return "NO " + std::string(verb) + " unknown\n";
}

std::string CameraTwin::snap(std::int64_t number, std::int64_t now_us) {
  settings_.t_us = now_us;
  ++settings_.number;
  const TakenPicture p = scene_(settings_);
  std::string pixels = pixel_bytes(p);
  const std::uint32_t sum = fletcher(pixels);
  if (trip_ == 2) pixels[pixels.size() / 2] = char(pixels[pixels.size() / 2] ^ 0x10);
  const std::int64_t age_us = std::int64_t(settings_.exposure_us) + params_.readout_us + params_.latency_us;
  return "OK SNAP " + std::to_string(number) + ' ' + std::to_string(p.width) + ' ' +
         std::to_string(p.height) + ' ' + std::to_string(p.white) + ' ' + std::to_string(age_us) + ' ' +
         std::to_string(pixels.size()) + ' ' + std::to_string(sum) + '\n' + pixels;
}

void CameraTwin::reboot(std::int64_t) {
  ++boot_count_;
  line_.clear();
  settings_ = {};
}

}  // namespace firn::plant
