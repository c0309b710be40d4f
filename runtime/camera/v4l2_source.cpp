#include "runtime/camera/v4l2_source.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace firn::camera {
namespace {

constexpr unsigned kBuffers = 4, kMinBuffers = 2;
constexpr int kSlice_ms = 20, kMaxFormats = 256, kMaxBad = 16, kStale = 2;
constexpr double kWithin_us = 2e6;  // beyond the exposure
constexpr double kExposureUnit_us = 100.0;
constexpr int kMinSide = 16, kMaxSide = 16384;

template <class T>
T zeroed() {
  T t;
  std::memset(&t, 0, sizeof t);
  return t;
}

template <class Argument>
Argument of_capture() {
  Argument a = zeroed<Argument>();
  a.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  return a;
}

bool gone(int error) { return error == ENODEV || error == ENXIO || error == EIO || error == EBADF; }

bool can_read(const PixelFormat& f, const V4l2Options& options) {
  return f.layout != PixelFormat::Layout::kJpeg || options.decode;
}

std::string known_names(const V4l2Options& options) {
  std::string names;
  for (const PixelFormat& f : pixel_formats())
    if (can_read(f, options)) names += (names.empty() ? "" : ", ") + std::string(f.name);
  return names;
}

}  // namespace

V4l2Source::V4l2Source(std::unique_ptr<VideoDevice> device, V4l2Options options)
    : device_(std::move(device)), options_(std::move(options)) {
  try {
    auto caps = zeroed<v4l2_capability>();
    must(VIDIOC_QUERYCAP, &caps, "is no V4L2 device");
    const std::uint32_t has = caps.capabilities & V4L2_CAP_DEVICE_CAPS ? caps.device_caps : caps.capabilities;
    if (!(has & V4L2_CAP_VIDEO_CAPTURE)) throw std::runtime_error("captures no pictures");
    if (!(has & V4L2_CAP_STREAMING)) throw std::runtime_error("cannot stream its pictures");
    const auto* card = reinterpret_cast<const char*>(caps.card);
    name_ = std::string(card, strnlen(card, sizeof caps.card));
    for (char& c : name_)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    choose_format();
    begin_streaming();
  } catch (...) {
    end();
    throw;
  }
}

V4l2Source::~V4l2Source() { end(); }

void V4l2Source::end() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (!buffers_.empty()) call(VIDIOC_STREAMOFF, &type);
  for (const Buffer& b : buffers_) device_->unmap(b.at, b.bytes);
  buffers_.clear();
}

int V4l2Source::call(unsigned long request, void* argument) {
  int result = 0;
  do result = device_->control(request, argument);
  while (result < 0 && errno == EINTR);
  return result;
}

void V4l2Source::must(unsigned long request, void* argument, const char* what) {
  if (call(request, argument) == 0) return;
  const std::string why = std::string(what) + ": " + std::strerror(errno);
  if (gone(errno)) throw SourceGone(why);
  throw std::runtime_error(why);
}

void V4l2Source::choose_format() {
  std::string offered;
  const PixelFormat* best = nullptr;
  for (int n = 0; n < kMaxFormats; ++n) {
    auto f = of_capture<v4l2_fmtdesc>();
    f.index = std::uint32_t(n);
    if (call(VIDIOC_ENUM_FMT, &f) != 0) break;
    offered += (offered.empty() ? "" : ", ") + fourcc_text(f.pixelformat);
    const PixelFormat* format = pixel_format(f.pixelformat);
    if (!format || (!options_.format.empty() && format->name != options_.format)) continue;
    if (!can_read(*format, options_)) continue;
    if (!best || format < best) best = format;
  }
  if (!best)
    throw std::runtime_error("offers " + (offered.empty() ? std::string("no format") : offered) +
                             ", none of " +
                             (options_.format.empty() ? known_names(options_) : options_.format));
  auto format = of_capture<v4l2_format>();
  must(VIDIOC_G_FMT, &format, "tells no format");
  v4l2_pix_format& pix = format.fmt.pix;
  if (options_.width > 0) {
    pix.width = std::uint32_t(options_.width);
    pix.height = std::uint32_t(options_.height);
  }
  pix.pixelformat = best->fourcc;
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = pix.sizeimage = 0;
  must(VIDIOC_S_FMT, &format, "refuses the format");
  if (pix.pixelformat != best->fourcc)
    throw std::runtime_error("gives " + fourcc_text(pix.pixelformat) + " where " + std::string(best->name) +
                             " was asked for");
  if (options_.width > 0 &&
      (pix.width != std::uint32_t(options_.width) || pix.height != std::uint32_t(options_.height)))
    throw std::runtime_error("gives " + std::to_string(pix.width) + " x " + std::to_string(pix.height) +
                             " px where " + std::to_string(options_.width) + " x " +
                             std::to_string(options_.height) + " were asked for");
  if (pix.width < kMinSide || pix.height < kMinSide || pix.width > kMaxSide || pix.height > kMaxSide)
    throw std::runtime_error("gives pictures of " + std::to_string(pix.width) + " x " +
                             std::to_string(pix.height) + " px: a side is outside [16, 16384]");
  format_ = best;
  width_ = int(pix.width);
  height_ = int(pix.height);
  stride_ = std::max<std::size_t>(pix.bytesperline, row_bytes(*best, width_));
}

void V4l2Source::begin_streaming() {
  auto request = of_capture<v4l2_requestbuffers>();
  request.count = kBuffers;
  request.memory = V4L2_MEMORY_MMAP;
  must(VIDIOC_REQBUFS, &request, "has no buffers to map");
  if (request.count < kMinBuffers)
    throw std::runtime_error("gives " + std::to_string(request.count) + " buffers, 2 are needed");
  for (unsigned n = 0; n < request.count; ++n) {
    auto b = of_capture<v4l2_buffer>();
    b.index = n;
    b.memory = V4L2_MEMORY_MMAP;
    must(VIDIOC_QUERYBUF, &b, "does not describe its buffers");
    void* at = device_->map(b.length, b.m.offset);
    if (!at) throw std::runtime_error(std::string("its buffers cannot be mapped: ") + std::strerror(errno));
    buffers_.push_back({at, b.length});
    queue(n);
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  must(VIDIOC_STREAMON, &type, "does not begin to stream");
}

void V4l2Source::queue(unsigned index) {
  auto b = of_capture<v4l2_buffer>();
  b.index = index;
  b.memory = V4L2_MEMORY_MMAP;
  must(VIDIOC_QBUF, &b, "takes no buffer back");
}

bool V4l2Source::set_control(std::uint32_t id, std::int64_t value, std::string& why) {
  auto range = zeroed<v4l2_queryctrl>();
  range.id = id;
  if (call(VIDIOC_QUERYCTRL, &range) != 0 || range.flags & V4L2_CTRL_FLAG_DISABLED) {
    why = "the device has no such control";
    return false;
  }
  if (value < range.minimum || value > range.maximum) {
    why = std::to_string(value) + " is outside [" + std::to_string(range.minimum) + ", " +
          std::to_string(range.maximum) + "], the control's range";
    return false;
  }
  auto control = zeroed<v4l2_control>();
  control.id = id;
  control.value = std::int32_t(value);
  if (call(VIDIOC_S_CTRL, &control) == 0) return true;
  if (gone(errno)) throw SourceGone(std::strerror(errno));
  why = std::strerror(errno);
  return false;
}

std::string V4l2Source::set_up(const ShotSettings& s) {
  if (s.delay_us != options_.delay_us)
    return "a strobe delay of " + std::to_string(s.delay_us) + " us is not that of the port's address, " +
           std::to_string(options_.delay_us) + " us, and the device sets none";
  std::string why;
  auto manual = zeroed<v4l2_control>();
  manual.id = V4L2_CID_EXPOSURE_AUTO;
  manual.value = V4L2_EXPOSURE_MANUAL;
  call(VIDIOC_S_CTRL, &manual);  // a device without automatic exposure has no such control
  const auto units = std::int64_t(std::llround(std::max(1.0, s.exposure_us / kExposureUnit_us)));
  if (!set_control(V4L2_CID_EXPOSURE_ABSOLUTE, units, why)) return "exposure: " + why;
  if (!set_control(V4L2_CID_GAIN, std::llround(s.gain_db), why) && s.gain_db != 0.0) return "gain: " + why;
  exposure_us_ = s.exposure_us;
  return {};
}

GreyShot V4l2Source::take(const std::function<bool()>& ended) {
  const std::int64_t asked_us = device_->now_us();
  const auto until_us = asked_us + std::int64_t(exposure_us_ + kWithin_us);
  int bad = 0, old = 0;
  std::string last;
  while (bad < kMaxBad) {
    if (ended && ended()) throw std::runtime_error("the picture is not wanted any more");
    if (device_->now_us() >= until_us)
      throw std::runtime_error("no picture within " + std::to_string((until_us - asked_us) / 1000) + " ms" +
                               last);
    const int ready = device_->wait(kSlice_ms);
    if (ready < 0 && errno != EINTR) throw SourceGone(std::string("unplugged: ") + std::strerror(errno));
    if (ready <= 0) continue;
    auto b = of_capture<v4l2_buffer>();
    b.memory = V4L2_MEMORY_MMAP;
    if (call(VIDIOC_DQBUF, &b) != 0) {
      if (errno == EAGAIN) continue;
      throw SourceGone(std::string("unplugged: ") + std::strerror(errno));
    }
    if (b.index >= buffers_.size()) throw SourceGone("gives a buffer that it does not have");
    const bool stamped = (b.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    const std::int64_t stamp_us = std::int64_t(b.timestamp.tv_sec) * 1'000'000 + b.timestamp.tv_usec;
    // Without the kernel's time of a frame, so many may have been under way.
    const bool stale = stamped ? stamp_us < asked_us : old < kStale;
    if (stale) {
      ++old;
      queue(b.index);
      continue;
    }
    const Buffer& buffer = buffers_[b.index];
    const std::size_t used = std::min<std::size_t>(b.bytesused, buffer.bytes);
    GreyShot shot{width_, height_, format_->white, 0, {}};
    try {
      if (b.flags & V4L2_BUF_FLAG_ERROR) throw std::length_error("a frame that the device marks as damaged");
      const std::span frame(static_cast<const std::byte*>(buffer.at), used);
      shot.pixels = format_->layout == PixelFormat::Layout::kJpeg
                        ? options_.decode(frame, width_, height_)
                        : grey_levels(*format_, width_, height_, stride_, frame);
    } catch (const std::length_error& problem) {
      ++bad;
      last = std::string(": ") + problem.what();
      queue(b.index);
      continue;
    }
    queue(b.index);
    shot.age_us = std::clamp<std::int64_t>(stamped ? device_->now_us() - stamp_us : 0, 0, 60'000'000);
    return shot;
  }
  throw std::runtime_error(std::to_string(bad) + " frames in a row are damaged" + last);
}

}  // namespace firn::camera
