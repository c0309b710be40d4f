// Camera controls a camera behind Firn's line protocol (picture_line.h): settings, and sweeps of pictures at
// strobe delays. It moves, fires and lights nothing that could harm.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/camera/camera_driver.h"
#include "drivers/camera/picture_line.h"

namespace firn::drivers {

class Camera final : public CameraDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Camera(CameraOptions config);

  /// A picture that does not come is asked for twice more; then the sweep has failed.
  void sweep(const Sweep& sweep, std::int64_t now_us, Effects& fx) override;
  void set_up(const Sweep& sweep, std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return op_ != Op::kNone; }

 private:
  enum class Op : std::uint8_t { kNone, kSweep, kSetUp };
  enum class Phase : std::uint8_t { kDown, kIdentifying, kReady, kTaking };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return false; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  void begin(Op op, const Sweep& sweep, Effects& fx);
  void ask(std::int32_t index);
  void take(std::span<const std::byte> frame, Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);

  CameraOptions config_;
  picture_line::PictureLineDialect dialect_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  Sweep sweep_;
  std::int32_t taken_ = 0;
  std::int32_t number_ = 0;  ///< of the newest picture asked for
  std::string ending_;
};

}  // namespace firn::drivers
