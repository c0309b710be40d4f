#include "runtime/camera/video_device.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace firn::camera {
namespace {

class KernelVideoDevice final : public VideoDevice {
 public:
  explicit KernelVideoDevice(int fd) : fd_(fd) {}
  ~KernelVideoDevice() override { ::close(fd_); }
  int control(unsigned long request, void* argument) override { return ::ioctl(fd_, request, argument); }
  void* map(std::size_t bytes, std::int64_t offset) override {
    void* at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, off_t(offset));
    return at == MAP_FAILED ? nullptr : at;
  }
  void unmap(void* at, std::size_t bytes) override { ::munmap(at, bytes); }
  int wait(int ms) override {
    pollfd p{fd_, POLLIN, 0};
    const int n = ::poll(&p, 1, ms);
    if (n > 0 && !(p.revents & POLLIN)) {
      errno = ENODEV;
      return -1;
    }
    return n;
  }
  std::int64_t now_us() const override {
    timespec t{};
    ::clock_gettime(CLOCK_MONOTONIC, &t);
    return std::int64_t(t.tv_sec) * 1'000'000 + t.tv_nsec / 1000;
  }

 private:
  int fd_;
};

}  // namespace

std::unique_ptr<VideoDevice> open_video_device(const std::string& file, std::string& why) {
  const int fd = ::open(file.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd >= 0) return std::make_unique<KernelVideoDevice>(fd);
  why = std::strerror(errno);
  return nullptr;
}

}  // namespace firn::camera
