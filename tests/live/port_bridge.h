// PortBridge puts a socket of a simulated world behind a serial line (a pseudo terminal) or a TCP port of
// this host, as if the instrument were real.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

namespace firn::test {

class PortBridge {
 public:
  enum class Kind { kSerial, kTcp };
  /// @param baud bytes go no faster than this, eight data bits with a start and a stop bit; 0 = as they come
  PortBridge(Kind kind, const std::filesystem::path& socket, int baud = 0);
  ~PortBridge();
  PortBridge(const PortBridge&) = delete;
  PortBridge& operator=(const PortBridge&) = delete;

  /// "tcp:127.0.0.1:40123" or "serial:/dev/pts/7?baud=115200".
  std::string address(int baud = 115200) const;

 private:
  void serve();
  void carry(int host);

  Kind kind_;
  std::filesystem::path socket_;
  int baud_;
  int listener_ = -1, port_ = 0;  // TCP
  int master_ = -1;               // serial
  std::string slave_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace firn::test
