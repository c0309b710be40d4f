// RealWire carries an instrument's bytes through this host's kernel, over a pseudo terminal or a TCP
// connection, without a clock: bytes written on one side are read on the other before the call returns.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/port_wire.h"

namespace firn::drivers::test {

class RealWire {
 public:
  enum class Kind { kSerial, kTcp };
  /// @param name of the serial line: a link to the pseudo terminal of the moment, as udev makes them by-id
  RealWire(Kind kind, const std::filesystem::path& name);
  ~RealWire();
  RealWire(const RealWire&) = delete;

  void open();  ///< by the host
  /// By the instrument: the cable is pulled out, the master is closed, the connection is reset. Throws
  /// std::runtime_error if the host's side does not notice.
  void end();
  std::string to_instrument(std::string_view bytes);
  std::string to_host(std::string_view bytes);

 private:
  PortAddress address() const;

  Kind kind_;
  std::filesystem::path name_;
  int listener_ = -1, tcp_port_ = 0;
  int far_ = -1;
  std::optional<PortWire> wire_;
};

}  // namespace firn::drivers::test
