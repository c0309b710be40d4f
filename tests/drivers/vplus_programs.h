// Tests of the V+ programs' parts: some of their programs run with the rest replaced.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace firn::drivers::test {

/// A client's doings, and the network device's reports of them.
struct ClientEvent {
  enum class Kind { kComes, kSends, kGoes } kind = Kind::kSends;
  std::string bytes;
};

struct ServedNetwork {
  std::vector<std::string> heard;  ///< lines whose check has four characters, without it
  std::vector<std::string> typed;  ///< on the controller's monitor
};
/// Runs fv.link of `text`, and of its other programs fv.lines and fv.line, for five seconds.
/// @param gone IOSTAT's number of a client that has closed: 101, or -562 by other firmware
ServedNetwork serve_network(const std::string& text, const std::vector<ClientEvent>& events, int gone = 101);

struct Calibrated {
  int times = 0;
  std::string stopped_by;  ///< the error that ended the main program
};
/// Runs a.firn of `text` with a request to calibrate.
Calibrated calibrate_by(const std::string& text);

}  // namespace firn::drivers::test
