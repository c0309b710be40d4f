// V4l2Source takes grey pictures from a V4L2 capture device by memory-mapped streaming.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime/camera/picture_source.h"
#include "runtime/camera/pixel_format.h"
#include "runtime/camera/video_device.h"

namespace firn::camera {

struct V4l2Options {
  int width = 0, height = 0;  ///< 0: as the device has them
  std::string format;         ///< "GREY", …; empty: the deepest that the device has
  double delay_us = 0.0;      ///< of the strobe, which the device does not set
  JpegDecoder decode;         ///< of frames in MJPG; empty: there is none, and MJPG is not taken
};

class V4l2Source final : public PictureSource {
 public:
  /// Negotiates format and buffers and begins to stream.
  /// @throws std::runtime_error: no capture device, none of the formats, another size than asked for, …
  V4l2Source(std::unique_ptr<VideoDevice> device, V4l2Options options);
  ~V4l2Source() override;

  std::string name() const override { return name_; }
  /// Exposure by V4L2_CID_EXPOSURE_ABSOLUTE, to the control's 100 us; the gain by V4L2_CID_GAIN, whose unit
  /// is the device's own. Refused: a control that the device lacks, unless the value is the default; a strobe
  /// delay other than V4l2Options::delay_us.
  std::string set_up(const ShotSettings& settings) override;
  /// Frames that the device marks as damaged, that are short or were exposed before the call are given back.
  GreyShot take(const std::function<bool()>& ended) override;

 private:
  struct Buffer {
    void* at = nullptr;
    std::size_t bytes = 0;
  };
  int call(unsigned long request, void* argument);  ///< again after EINTR
  void must(unsigned long request, void* argument, const char* what);
  void choose_format();
  void begin_streaming();
  void queue(unsigned index);
  bool set_control(std::uint32_t id, std::int64_t value, std::string& why);
  void end();

  std::unique_ptr<VideoDevice> device_;
  V4l2Options options_;
  std::string name_;
  const PixelFormat* format_ = nullptr;
  int width_ = 0, height_ = 0;
  std::size_t stride_ = 0;
  double exposure_us_ = 0.0;
  std::vector<Buffer> buffers_;
};

}  // namespace firn::camera
