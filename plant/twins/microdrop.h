// MicrodropTwin simulates the dispenser Microdrop MD-E: lines at 19200 baud. The head behind it is the
// JetDrive's; its external trigger is set by the words of JetParams, which are ours [P].
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "plant/twins/jet.h"

namespace firn::plant {

class MicrodropTwin final : public JetTwin {
 public:
  MicrodropTwin(Port port, JetParams params, Wires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { line_.clear(); }
  void reboot(std::int64_t now_us) override;
  void io(Archive& a) override;

 private:
  std::string execute(std::string_view line, std::int64_t now_us);

  std::string line_;
  bool active_ = false;
  std::array<int, 3> words_{};  ///< voltage [V], length and delay [us]
};

}  // namespace firn::plant
