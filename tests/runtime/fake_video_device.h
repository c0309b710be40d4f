// FakeVideoDevice plays the kernel of a V4L2 camera: formats, buffers, frames, faults.
#pragma once

#include <linux/videodev2.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <vector>

#include "runtime/camera/video_device.h"

namespace firn::test {

struct FakeFrame {
  std::vector<std::uint8_t> bytes;
  std::int64_t exposed_us = 0;
  bool damaged = false, stamped = true;
};

/// The state of the device, shared with the test.
struct FakeCamera {
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY};
  std::uint32_t given = 0;  ///< the format that it sets whatever is asked; 0: the one asked for
  std::uint32_t width = 32, height = 16, padding = 0, max_buffers = 4;
  std::map<std::uint32_t, std::pair<int, int>> controls{{V4L2_CID_EXPOSURE_ABSOLUTE, {1, 10000}}};
  std::map<std::uint32_t, int> set;
  std::deque<FakeFrame> frames;
  std::int64_t now_us = 1'000'000;
  int interrupts = 0;  ///< calls that end with EINTR before the next one goes on
  bool unplugged = false;
  int mapped = 0, queued = 0;
  bool streaming = false;
};

class FakeVideoDevice final : public camera::VideoDevice {
 public:
  explicit FakeVideoDevice(FakeCamera& camera) : c_(camera) {}

  int control(unsigned long request, void* argument) override {
    if (c_.interrupts > 0) {
      --c_.interrupts;
      return fail(EINTR);
    }
    if (c_.unplugged) return fail(ENODEV);
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto& a = *static_cast<v4l2_capability*>(argument);
        std::memcpy(a.card, "fake\ncamera", 12);
        a.capabilities = c_.capabilities;
        return 0;
      }
      case VIDIOC_ENUM_FMT: {
        auto& a = *static_cast<v4l2_fmtdesc*>(argument);
        if (a.index >= c_.formats.size()) return fail(EINVAL);
        a.pixelformat = c_.formats[a.index];
        return 0;
      }
      case VIDIOC_G_FMT:
      case VIDIOC_S_FMT: {
        auto& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
        pix.width = c_.width;
        pix.height = c_.height;
        if (c_.given) pix.pixelformat = c_.given;
        pixel_bytes_ = pix.pixelformat == V4L2_PIX_FMT_GREY ? 1 : 2;
        pix.bytesperline = c_.width * pixel_bytes_ + c_.padding;
        pix.sizeimage = pix.bytesperline * c_.height;
        return 0;
      }
      case VIDIOC_REQBUFS: {
        auto& a = *static_cast<v4l2_requestbuffers*>(argument);
        a.count = std::min(a.count, c_.max_buffers);
        memory_.assign(a.count, std::vector<std::uint8_t>((c_.width * 2 + c_.padding) * c_.height));
        return 0;
      }
      case VIDIOC_QUERYBUF: {
        auto& a = *static_cast<v4l2_buffer*>(argument);
        a.length = std::uint32_t(memory_.at(a.index).size());
        a.m.offset = a.index;
        return 0;
      }
      case VIDIOC_QBUF:
        waiting_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        ++c_.queued;
        return 0;
      case VIDIOC_DQBUF: {
        if (c_.frames.empty() || waiting_.empty()) return fail(EAGAIN);
        auto& a = *static_cast<v4l2_buffer*>(argument);
        const FakeFrame f = c_.frames.front();
        c_.frames.pop_front();
        a.index = waiting_.front();
        waiting_.pop_front();
        --c_.queued;
        std::memcpy(memory_[a.index].data(), f.bytes.data(),
                    std::min(f.bytes.size(), memory_[a.index].size()));
        a.bytesused = std::uint32_t(f.bytes.size());
        a.flags = (f.damaged ? V4L2_BUF_FLAG_ERROR : 0u) |
                  (f.stamped ? V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC : V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN);
        a.timestamp.tv_sec = f.exposed_us / 1'000'000;
        a.timestamp.tv_usec = f.exposed_us % 1'000'000;
        return 0;
      }
      case VIDIOC_STREAMON:
        c_.streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        c_.streaming = false;
        return 0;
      case VIDIOC_QUERYCTRL: {
        auto& a = *static_cast<v4l2_queryctrl*>(argument);
        const auto at = c_.controls.find(a.id);
        if (at == c_.controls.end()) return fail(EINVAL);
        a.minimum = at->second.first;
        a.maximum = at->second.second;
        return 0;
      }
      case VIDIOC_S_CTRL: {
        const auto& a = *static_cast<v4l2_control*>(argument);
        if (a.id != V4L2_CID_EXPOSURE_AUTO && !c_.controls.count(a.id)) return fail(EINVAL);
        c_.set[a.id] = a.value;
        return 0;
      }
      default:
        return fail(ENOTTY);
    }
  }
  void* map(std::size_t, std::int64_t offset) override {
    ++c_.mapped;
    return memory_.at(std::size_t(offset)).data();
  }
  void unmap(void*, std::size_t) override { --c_.mapped; }
  int wait(int ms) override {
    if (c_.unplugged) return fail(ENODEV);
    if (!c_.frames.empty()) return 1;
    c_.now_us += 1000 * ms;
    return 0;
  }
  std::int64_t now_us() const override { return c_.now_us; }

 private:
  int fail(int error) {
    errno = error;
    return -1;
  }

  FakeCamera& c_;
  std::uint32_t pixel_bytes_ = 1;
  std::vector<std::vector<std::uint8_t>> memory_;
  std::deque<std::uint32_t> waiting_;
};

}  // namespace firn::test
