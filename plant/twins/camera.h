// CameraTwin simulates a camera behind Firn's line protocol: lines in, lines and pixels out. Pictures come
// from the world: of a jet, or of whatever a lab shows it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "plant/twins/twin.h"

namespace firn::plant {

struct CameraParams {
  std::string name = "simulated camera, serial 1";
  std::int64_t latency_us = 300;
  std::int64_t readout_us = 20'000;  ///< from the end of the exposure to the reply
};

/// The settings and the time of one exposure.
struct Exposure {
  std::int64_t t_us = 0;
  double exposure_us = 100.0, gain_db = 0.0, delay_us = 0.0;
  std::uint32_t number = 0;  ///< of the exposure since power on
};

/// Grey levels, rows from the top; white is 255 or more.
struct TakenPicture {
  int width = 0, height = 0, white = 255;
  std::vector<std::uint16_t> pixels;
};

/// `ID`, `SET <exposure us> <gain dB> <delay us>`, `SNAP <number>`; each line ends in \n. `OK ID <name>`,
/// `OK SET`, `OK SNAP <number> <width> <height> <white> <age us> <bytes> <sum>` and the pixels, 1 byte each,
/// or 2, low byte first, where white > 255; `NO <verb> <why>`. The sum is Fletcher's over 16-bit words, low
/// byte first, modulo 65535, the second sum in the upper half.
class CameraTwin final : public Twin {
 public:
  using Scene = std::function<TakenPicture(const Exposure&)>;
  CameraTwin(const CameraParams& params, Scene scene);

  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { line_.clear(); }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  /// 1: it refuses to take pictures; 2: pixels are damaged on their way; 0: neither
  void trip(std::int64_t, std::int64_t code) override { trip_ = code; }
  void reboot(std::int64_t now_us) override;
  void io(Archive& a) override { a.all(boot_count_, line_, settings_, trip_, link_); }

 private:
  std::string execute(std::string_view line, std::int64_t now_us);
  std::string snap(std::int64_t number, std::int64_t now_us);

  CameraParams params_;
  Scene scene_;
  std::string line_;
  Exposure settings_;
  std::int64_t trip_ = 0;
};

}  // namespace firn::plant
