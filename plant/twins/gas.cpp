#include "plant/twins/gas.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/options/number.h"

namespace firn::plant {
namespace {

constexpr double kAir_kpa = 101.325, kPsi_kpa = 6.894757;
constexpr std::size_t kLongest = 40;
constexpr const char* kRefused = "?\r";
enum Trip : std::int64_t { kNoAtomizer = 1, kNoSheath, kClogs, kAnalog, kHeld, kSilent, kOtherUnit };

}  // namespace

GasTwin::GasTwin(Port port, GasParams params, Wires& wires)
    : Twin(port, TwinLink(10.0e6 / params.baud, 0)), params_(std::move(params)), wires_(wires) {}

void GasTwin::advance(std::int64_t now_us) {
  const double dt_s = double(now_us - at_us_) * 1e-6;
  if (dt_s <= 0.0) return;
  at_us_ = now_us;
  for (std::size_t n = 0; n < 2; ++n) {
    const bool cut = trip_ == (n == 0 ? kNoAtomizer : kNoSheath);
    const double goal = cut ? 0.0 : n == 0 && trip_ == kHeld ? sccm_[0] : set_sccm_[n];
    sccm_[n] += (goal - sccm_[n]) * (1.0 - std::exp(-dt_s / params_.settle_s));
  }
  if (trip_ == kClogs || (sccm_[0] > 1.0 && sccm_[1] < 1.0))
    clog_ *= std::exp(params_.clog_per_s * (trip_ == kClogs ? 10.0 : 1.0) * dt_s);
}

double GasTwin::sccm(int controller, std::int64_t now_us) {
  advance(now_us);
  return sccm_[std::size_t(controller)];
}

double GasTwin::nozzle_kpa(std::int64_t now_us) {
  advance(now_us);
  return kAir_kpa + params_.open_kpa_per_sccm * clog_ * (sccm_[0] + sccm_[1]) / (open_share_ * open_share_);
}

std::string GasTwin::data(int controller, std::int64_t now_us) {
  const auto n = std::size_t(controller);
  const double psi = std::min(nozzle_kpa(now_us) / kPsi_kpa, 999.99);
  const double shown = std::min(sccm_[n], 1.28 * params_.full_sccm[n]);
  char text[120];
  std::snprintf(text, sizeof text, "%c %+07.2f %+07.2f %+07.2f %+07.2f %+07.2f %6s", params_.units[n], psi,
                22.0, shown * kAir_kpa / (psi * kPsi_kpa), shown, set_sccm_[n], params_.gas.c_str());
  std::string line = text;
  if (trip_ == kHeld && n == 0) line += " HLD";
  return line + '\r';
}

std::string GasTwin::set(int controller, std::string_view value, std::int64_t now_us) {
  const auto n = std::size_t(controller);
  const std::optional<double> sccm = whole_number(value, 0.0, params_.full_sccm[n]);
  if (!sccm) return kRefused;
  advance(now_us);
  if (trip_ != kAnalog) set_sccm_[n] = std::round(*sccm * 100.0) / 100.0;  // as it is shown
  return data(controller, now_us);
}

std::string GasTwin::execute(std::string_view line, std::int64_t now_us) {
  std::size_t n = line.empty() ? std::string::npos : params_.units.find(line[0]);
  if (n == 1 && (trip_ == kSilent || trip_ == kOtherUnit)) n = std::string::npos;
  if (n == std::string::npos) return "";  // another unit's, if there is one
  std::string_view command = line.substr(1);
  if (command.empty()) return data(int(n), now_us);
  const std::string id(1, params_.units[n]);
  if (command == "VE")
    return id + (params_.gp_firmware ? "   GP07R100\r" : "   10v20.0-R24 Jan  9 2025,15:04:07\r");
  if (params_.gp_firmware) {
    if (!command.starts_with("$$")) return kRefused;
    command.remove_prefix(2);
  }
  if (command.starts_with('S')) return set(int(n), command.substr(1), now_us);
  if (command != "??M*") return kRefused;
  const char* const lines[] = {"M00 ALICAT SCIENTIFIC", "M04 Model Number MC-SCCM-D",
                               "M05 Serial Number 52164", "M09 Software Revision 10v20.0-R24"};
  std::string text;
  for (const char* l : lines) text += id + "  " + l + (l[2] == '5' ? id : "") + '\r';
  return text;
}

void GasTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    if (char(b) != '\r') {
      if (line_.size() < kLongest) line_.push_back(char(b));
      continue;
    }
    if (const std::string answer = execute(line_, now_us); !answer.empty()) link_.reply(answer, now_us);
    line_.clear();
  }
}

void GasTwin::reboot(std::int64_t now_us) {
  advance(now_us);
  ++boot_count_;
  line_.clear();
  set_sccm_ = {};
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void GasTwin::trip(std::int64_t now_us, std::int64_t code) {
  advance(now_us);
  trip_ = code;
  if (code == 0) clog_ = 1.0;  // whoever ends the fault cleans the nozzle
}

}  // namespace firn::plant
