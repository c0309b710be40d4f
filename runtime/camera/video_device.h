// VideoDevice is the part of the kernel that a V4L2 source needs: tests replace it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace firn::camera {

class VideoDevice {
 public:
  virtual ~VideoDevice() = default;
  /// @returns 0, or -1 with errno
  virtual int control(unsigned long request, void* argument) = 0;
  /// Memory of a buffer at this offset; nullptr with errno. unmap() gives it back.
  virtual void* map(std::size_t bytes, std::int64_t offset) = 0;
  virtual void unmap(void* at, std::size_t bytes) = 0;
  /// Waits until a picture can be taken. @returns 1, 0 after ms milliseconds, or -1 with errno
  virtual int wait(int ms) = 0;
  /// CLOCK_MONOTONIC, in which V4L2 stamps its buffers.
  virtual std::int64_t now_us() const = 0;
};

/// @param why of a null pointer
std::unique_ptr<VideoDevice> open_video_device(const std::string& file, std::string& why);

}  // namespace firn::camera
