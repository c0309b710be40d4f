// RawLine asks an instrument by bytes, past its driver: bring-up checks the ground on which the driver
// stands.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "runtime/ports.h"

namespace firn {

class RawLine {
 public:
  /// Opens the port, within 3 s, or 10 s where it does not say why it cannot be opened. @throws
  /// std::runtime_error: PortWire
  explicit RawLine(const PortAddress& address);

  bool is_open() const { return open_; }
  const std::string& trouble() const { return trouble_; }  ///< of a port that does not open

  void send(std::string_view bytes);
  /// Forgets earlier bytes, sends, and waits until `whole` holds of the answer. @returns the answer, whole or
  /// not
  std::string ask(std::string_view bytes, const std::function<bool(std::string_view)>& whole,
                  double within_s = 3.0);
  /// ask() for a line with its end.
  std::string ask_line(std::string_view bytes, char end = '\n', double within_s = 3.0);
  /// Lets time pass, listening.
  void wait(double s);
  double last_answer_s() const { return last_answer_s_; }  ///< time of the last ask()
  void close() { ports_.reopen(PortId{0}, INT64_MAX); }

 private:
  void turn(int max_ms);

  Ports ports_;
  bool open_ = false;
  std::string heard_, trouble_;
  double last_answer_s_ = 0.0;
};

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace firn
