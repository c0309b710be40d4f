// SocketAddress holds the address of a Unix socket in a folder of any depth.
#pragma once

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace firn {

/// The address holds 107 bytes; a longer path is reached through its open folder.
class SocketAddress {
 public:
  /// @throws std::runtime_error: the file's own name is too long
  explicit SocketAddress(const std::filesystem::path& path) {
    address_.sun_family = AF_UNIX;
    std::string text = path.string();
    if (text.size() >= sizeof address_.sun_path) {
      folder_ = ::open(path.parent_path().c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
      text = "/proc/self/fd/" + std::to_string(folder_) + "/" + path.filename().string();
    }
    if (text.size() >= sizeof address_.sun_path)
      throw std::runtime_error(path.string() + ": too long for the name of a Unix socket");
    std::memcpy(address_.sun_path, text.c_str(), text.size());
  }
  ~SocketAddress() {
    if (folder_ >= 0) ::close(folder_);
  }
  SocketAddress(const SocketAddress&) = delete;
  SocketAddress& operator=(const SocketAddress&) = delete;
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address_); }

 private:
  sockaddr_un address_{};
  int folder_ = -1;  // -1 as well when there is no such folder: nobody listens there
};

}  // namespace firn
