// CameraBridge answers Firn's camera protocol (docs/devices/camera.md) from a source of pictures, so that a
// V4L2 device or a folder is a port like all others.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "files/port_address.h"
#include "runtime/camera/picture_source.h"

namespace firn::camera {

/// The replies to request lines, without a socket.
class PictureServer {
 public:
  explicit PictureServer(PictureSource& source) : source_(source) {}
  /// @param line without its end. @returns the reply's bytes. @throws SourceGone
  std::string answer(std::string_view line, const std::function<bool()>& ended);

 private:
  PictureSource& source_;
};

class CameraBridge {
 public:
  /// Serves one side of a pair of sockets in a thread of its own until the other is closed or the source has
  /// gone, which closes it.
  explicit CameraBridge(std::unique_ptr<PictureSource> source);
  ~CameraBridge();
  CameraBridge(const CameraBridge&) = delete;
  CameraBridge& operator=(const CameraBridge&) = delete;

  /// The other side, nonblocking; it is the caller's.
  int take_fd();

 private:
  void serve();

  std::unique_ptr<PictureSource> source_;
  int own_ = -1, other_ = -1;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

/// Opens the source of an address of kind kV4l2 or kFolder. @throws std::runtime_error: why it cannot be
/// opened
std::unique_ptr<PictureSource> open_picture_source(const PortAddress& address);

}  // namespace firn::camera
