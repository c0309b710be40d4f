#include "drivers/camera/script_camera.h"

#include <cmath>
#include <utility>

namespace firn::drivers {
namespace {

constexpr double kMostWhite = 65535.0, kMostAge_s = 60.0;

/// Returns why these values are no picture; empty: `picture` is it.
std::string no_picture(const script::Line& line, Picture& picture) {
  const char* name = line.values.contains("pixels") ? "pixels" : "value";
  const auto at = line.values.find(name);
  const double rows = line.number(std::string(name) + "_rows");
  const double white = line.values.contains("white") ? line.number("white") : 255.0;
  const double age_s = line.values.contains("age_s") ? line.number("age_s") : 0.0;
  if (at == line.values.end() || !(rows >= 1.0)) return "it returns no (height, width) of grey levels";
  const std::vector<double>& grey = at->second;
  picture.height = std::int32_t(std::min(rows, double(kMaxPicture_px) + 1.0));
  picture.width = std::int32_t(grey.size() / std::size_t(picture.height));
  for (const std::int32_t side : {picture.height, picture.width})
    if (side < kMinPicture_px || side > kMaxPicture_px)
      return "a picture of " + std::to_string(picture.width) + " x " + std::to_string(picture.height) +
             " px has a side outside [" + std::to_string(kMinPicture_px) + ", " +
             std::to_string(kMaxPicture_px) + "] px";
  if (std::size_t(picture.width) * std::size_t(picture.height) != grey.size())
    return std::to_string(grey.size()) + " grey levels are no " + std::to_string(picture.height) +
           " whole rows";
  if (!(white >= 1.0 && white <= kMostWhite)) return "white is outside [1, 65535]";
  if (!(age_s >= 0.0 && age_s <= kMostAge_s)) return "age_s is outside [0, 60] s";
  picture.white = std::int32_t(white);
  picture.age_us = std::llround(age_s * 1e6);
  picture.pixels.reserve(grey.size());
  for (const double level : grey) {
    if (!(level >= 0.0 && level <= white))
      return "a grey level of " + std::to_string(level) + " is outside [0, " + std::to_string(picture.white) +
             "]";
    picture.pixels.push_back(std::uint16_t(level));
  }
  return {};
}

}  // namespace

ScriptCamera::ScriptCamera(ScriptOptions script, CameraOptions config)
    : ScriptDriver(std::move(script), {"picture"}), config_(config) {
  check_options("camera", kCameraConfig, config_);
}

bool ScriptCamera::takes(const Sweep& sweep, bool pictures, Effects& fx) {
  if (!accepts(fx)) return false;
  if (std::string why = refusal_of(sweep, pictures); !why.empty()) {
    refuse(kLimit, std::move(why), fx);
    return false;
  }
  begin_command();
  sweep_ = sweep;
  if (sweep_.exposure_us == 0.0) sweep_.exposure_us = config_.exposure_us;
  taken_ = 0;
  return true;
}

void ScriptCamera::sweep(const Sweep& sweep, std::int64_t now_us, Effects& fx) {
  if (takes(sweep, true, fx)) {
    set_state(DeviceState::kActive, "taking pictures", fx);
    ask(now_us);
  }
  pump(now_us, fx);
}

void ScriptCamera::set_up(const Sweep& sweep, std::int64_t now_us, Effects& fx) {
  if (takes(sweep, false, fx)) {
    config_.exposure_us = sweep_.exposure_us;
    config_.gain_db = sweep_.gain_db;
    finish({}, fx);
  }
  pump(now_us, fx);
}

void ScriptCamera::ask(std::int64_t now_us) {
  call(kPicture, "picture",
       {{"delay_us", {sweep_.delay_of(taken_)}},
        {"exposure_us", {sweep_.exposure_us}},
        {"gain_db", {sweep_.gain_db}}},
       now_us);
}

void ScriptCamera::returned(std::uint16_t, const Line& line, std::int64_t now_us, Effects& fx) {
  Picture picture;
  if (const std::string why = no_picture(line, picture); !why.empty())
    return wrong("picture", why, now_us, fx);
  fx.measured<CameraDriver>(CameraShot{taken_, sweep_, std::move(picture)});
  if (++taken_ < sweep_.frames) return ask(now_us);
  set_state(DeviceState::kSafe, "done", fx);
  finish({Outcome::kDone, taken_, sweep_.frames, 0, 0, kNoCode, ""}, fx);
}

Result ScriptCamera::broken_off(Outcome outcome, std::int32_t code, std::string text) {
  return {outcome, taken_, sweep_.frames, 0, 0, code, std::move(text)};
}

}  // namespace firn::drivers
