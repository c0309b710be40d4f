// LampTwin simulates the UV lamp Excelitas OmniCure S2000: `<cmd><CRC8><CR>` at 19200 baud, shutter, iris,
// timed exposure. It burns and is warm when a run begins; after a loss of power it is out until TON.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "plant/config/world_config.h"
#include "plant/twins/twin.h"

namespace firn::plant {

/// CRC-8, reflected polynomial 0x8C, start 0 (Dallas/Maxim): crc8("CONN") = 0x18.
std::uint8_t lamp_crc8(std::string_view text);

class LampTwin : public Twin {
 public:
  LampTwin(const LampParams& params, Wires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override {
    line_.clear();
  }  // no lost-link timeout is documented: it stays open
  std::int64_t next_device_us() const override { return state_.open ? state_.close_at_us : kNever; }
  void device_event(std::int64_t now_us) override;  ///< end of a timed exposure, or the longest on-time
  void reboot(std::int64_t now_us) override;
  /// 0: mended. 1: alarm. 2: the lamp goes out. 3: the shutter stays closed. 4: the shutter stays open.
  void trip(std::int64_t now_us, std::int64_t code) override;
  void io(Archive& a) override;

 private:
  struct State {
    bool talking = false;  ///< CONN was received
    bool open = false, alarm = false, alarm_held = false, locked = false, timed = false;
    bool burning = false, stuck_open = false, stuck_closed = false;
    std::int64_t warm_at_us = 0;
    int iris_percent = 100;
    int exposure_tenths = 0;  ///< of STM
    std::int64_t opened_us = 0, close_at_us = kNever;
    std::int64_t dose_from_us = 0;
    double dose_s = 0.0;  ///< up to dose_from_us
    void io(Archive& a) {
      a.all(talking, open, alarm, alarm_held, locked, timed, burning, stuck_open, stuck_closed, warm_at_us);
      a.all(iris_percent, exposure_tenths, opened_us, close_at_us, dose_from_us, dose_s);
    }
  };
  std::string execute(std::string_view command, std::int64_t now_us);
  void open(std::int64_t now_us, std::int64_t for_us, bool timed);
  void close(std::int64_t now_us, LampEvent why);
  int status(std::int64_t now_us) const;
  void add_dose(std::int64_t now_us);

  LampParams params_;
  Wires& wires_;
  State state_;
  std::string line_;
};

}  // namespace firn::plant
