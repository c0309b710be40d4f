#include "drivers/gas/gas.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace firn::drivers {
namespace {

constexpr double kExchanges = 4.0;  // that a host may be late with until a flow is seen to be there
constexpr int kNamings = 3;         // of another gas, until it is no damage of the line

void check_unit(const char* key, const std::string& unit) {
  if (unit.size() != 1 || unit[0] < 'A' || unit[0] > 'Z')
    throw std::invalid_argument(std::string("gas: ") + key + " = \"" + unit + "\" is no letter A to Z");
}

std::string shown(const char* format, double a, double b) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

Gas::Gas(GasOptions config) : GasDriver(dialect_, std::move(config)) {
  check_options("gas", kGasDialect, config_.dialect, "dialect.");
  check_unit("atomizer_unit", config_.atomizer_unit);
  check_unit("sheath_unit", config_.sheath_unit);
  if (config_.atomizer_unit == config_.sheath_unit)
    throw std::invalid_argument("gas: atomizer_unit and sheath_unit are both \"" + config_.sheath_unit +
                                "\"");
  dialect_.allow_host_latency(config_.host_latency_s);
  dialect_.probed = config_.atomizer_unit[0];
  identity_ = "Alicat mass-flow controllers";
}

void Gas::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kIdentifying;
  other_gas_.fill(0);
  dollars_.fill(false);
  version_.fill({});
  was_there_.fill(false);
  gone_since_us_.fill(0);
  wanted_sccm_[kAtomizer] = 0.0;  // whatever it was doing: ink flows by a command alone
  for (const int n : {kAtomizer, kSheath})
    link_.push(alicat::version_request(unit(n), config_.dialect, kVersionTag));
}

void Gas::send_set_point(int n) {
  const auto k = std::size_t(n);
  commanded_sccm_[k] = wanted_sccm_[k];
  link_.push(alicat::set_request(unit(n), wanted_sccm_[k] / config_.dialect.sccm_per_unit, config_.dialect,
                                 kSetTag));
}

void Gas::set(double atomizer_sccm, double sheath_sccm, std::int64_t now_us, Effects& fx) {
  std::string why = refusal_of(atomizer_sccm, sheath_sccm);
  std::int32_t code = kGas;
  if (busy() || phase_ != Phase::kReady) {
    why = busy() ? "the gas is busy with another command" : std::string("the gas is ") + standing();
    code = kNoCode;
  }
  if (!why.empty()) {
    fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, code, why});
  } else {
    op_ = true;
    wanted_sccm_ = {atomizer_sccm, sheath_sccm};
    first_ = atomizer_sccm < flows_.set_sccm[kAtomizer] ? kAtomizer : kSheath;
    set_state(DeviceState::kActive, "flows change", fx);
    begin_step(Phase::kFirst, first_, now_us);
  }
  pump(now_us, fx);
}

void Gas::begin_step(Phase phase, int n, std::int64_t now_us) {
  phase_ = phase;
  round_ = 0;
  was_there_[std::size_t(n)] = false;
  gone_since_us_[std::size_t(n)] = 0;
  settle_until_us_ = now_us + std::int64_t((config_.settle_s + kExchanges * config_.host_latency_s) * 1e6);
  next_read_us_ = now_us;
  send_set_point(n);
}

void Gas::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx, const Figure& figure) {
  if (!op_) return;
  op_ = false;
  fx.events.emplace_back(Result{outcome, -1, 0, 0, 0, code, std::move(text), figure});
}

// The sheath goes on: what is in the nozzle dries at its rim without it.
void Gas::end_atomizer(std::int64_t now_us, Effects& fx) {
  link_.clear_queue();
  phase_ = Phase::kStopping;
  wanted_sccm_[kAtomizer] = commanded_sccm_[kAtomizer] = 0.0;
  const Request zero = alicat::set_request(unit(kAtomizer), 0.0, config_.dialect, kSetTag);
  link_.urgent(zero, now_us, fx);
  if (link_.suspect()) link_.push(zero);  // the first answer is drained
}

void Gas::stop(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kIdentifying || phase_ == Phase::kStopping) return;
  if (phase_ == Phase::kRefused) return;  // nothing was ever sent to it
  finish(Outcome::kFailed, kNoCode, "safe stop", fx);
  end_atomizer(now_us, fx);
}

Figure Gas::settled_share(int n) const {
  const double wanted_sccm = wanted_sccm_[std::size_t(n)], sccm = flows_.sccm[std::size_t(n)];
  const double tolerance_share = (sccm < wanted_sccm ? -1.0 : 1.0) * tolerance_sccm(n) / wanted_sccm;
  return {sccm / wanted_sccm, 1.0 + tolerance_share, "", "gas.tolerance"};
}

void Gas::refused(const Request& request, const std::string& why, std::int64_t now_us, Effects& fx) {
  const int n = index_of(request);
  flows_.fault[std::size_t(n)] = GasFault::kSetPoint;
  const std::string text = std::string(name_of(n)) + ": " + why;
  if (phase_ == Phase::kStopping || phase_ == Phase::kIdentifying) {
    fault(Severity::kStop, kGas, "gas: " + text + "; close its bottle", fx);
    return reconnect(now_us, fx, text);
  }
  fault(Severity::kStop, kGas, "gas: " + text, fx);
  finish(Outcome::kFailed, kCommandRejected, text, fx);
  end_atomizer(now_us, fx);
}

void Gas::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) {
  const std::string_view line = alicat::text_of(frame);
  const int n = index_of(request);
  if (alicat::is_refusal(line)) {
    if (request.tag == kSetTag)
      return refused(request, "it refuses '" + std::string(alicat::text_of(request.data())) + "'", now_us,
                     fx);
    return reconnect(now_us, fx, std::string(name_of(n)) + " refuses a question");
  }
  if (request.tag == kVersionTag) {
    std::string_view text = line.substr(1);
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    const bool told = request.format == alicat::kVersion;
    version_[std::size_t(n)] = told ? text.substr(0, text.find(' ')) : "GP, which does not tell its version";
    dollars_[std::size_t(n)] = !told || text.starts_with("GP");
    if (version_[kAtomizer].empty() || version_[kSheath].empty()) return;
    identity_ = "Alicat " + config_.atomizer_unit + " firmware " + version_[kAtomizer] + ", " +
                config_.sheath_unit + " firmware " + version_[kSheath];
    send_set_point(kAtomizer);
    link_.push(alicat::poll_request(unit(kSheath), kReadTag));
    return;
  }
  const std::optional<alicat::Reading> r = alicat::parse_reading(line);
  if (!r) return;
  take(n, *r, now_us, fx);
  if (phase_ == Phase::kRefused) return;
  if (request.tag == kSetTag && std::abs(flows_.set_sccm[std::size_t(n)] - commanded_sccm_[std::size_t(n)]) >
                                    tolerated_sccm_[std::size_t(n)])
    return refused(request,
                   shown("told %.4g sccm its set point is %.4g sccm: analog or panel control?",
                         commanded_sccm_[std::size_t(n)], flows_.set_sccm[std::size_t(n)]),
                   now_us, fx);
  if (request.tag == kReadTag && n == kSheath) judge(now_us, fx);
}

void Gas::take(int n, const alicat::Reading& r, std::int64_t now_us, Effects& fx) {
  const auto k = std::size_t(n);
  const GasDialect& d = config_.dialect;
  flows_.sccm[k] = r.mass_flow * d.sccm_per_unit;
  flows_.set_sccm[k] = r.set_point * d.sccm_per_unit;
  flows_.kpa[k] = r.pressure * d.kpa_per_unit;
  flows_.celsius[k] = r.temperature_degC;
  tolerated_sccm_[k] = 1.01 * r.resolution * d.sccm_per_unit;
  const std::uint16_t bad = r.codes & alicat::kUntrusted;
  if (flows_.fault[k] == GasFault::kCode && bad == 0) flows_.fault[k] = GasFault::kNone;
  if (bad != 0 && flows_.fault[k] == GasFault::kNone &&
      (commanded_sccm_[kAtomizer] > 0.0 || bad & alicat::kHold)) {
    flows_.fault[k] = GasFault::kCode;
    const bool flows = commanded_sccm_[kAtomizer] > 0.0;
    fault(flows ? Severity::kStop : Severity::kWarning, kGas,
          std::string("gas: ") + name_of(n) + ": " + alicat::names_of(bad) + ": " + name(GasFault::kCode),
          fx);
    if (flows && phase_ != Phase::kStopping) {
      finish(Outcome::kFailed, kGas, alicat::names_of(bad), fx);
      end_atomizer(now_us, fx);
    }
  }
  if (phase_ != Phase::kIdentifying) return;
  other_gas_[k] = r.gas == config_.gas ? 0 : other_gas_[k] + 1;
  if (other_gas_[k] == 0) return;
  if (other_gas_[k] < kNamings) return link_.push(alicat::poll_request(unit(n), kReadTag));
  const std::string why = std::string(name_of(n)) + " is set to " + std::string(r.gas) + ", gas.gas is \"" +
                          config_.gas + "\": select it at its panel";
  phase_ = Phase::kRefused;
  link_.clear_queue();
  set_state(DeviceState::kFault, why, fx);
  fault(Severity::kStop, kLimit, "gas: " + why, fx);
}

// One round of readings is there.
void Gas::judge(std::int64_t now_us, Effects& fx) {
  ++round_;
  flows_.steady = there(kAtomizer) && there(kSheath) && phase_ == Phase::kReady;
  const auto stop_for = [&](GasFault what, int n, const std::string& text, const Figure& figure) {
    flows_.fault[std::size_t(n)] = what;
    fault(Severity::kStop, kGas, std::string("gas: ") + name_of(n) + ": " + text, fx, figure);
    finish(Outcome::kFailed, kGas, text, fx, figure);
    if (phase_ != Phase::kStopping) end_atomizer(now_us, fx);
  };
  for (const int n : {kAtomizer, kSheath}) {
    const auto k = std::size_t(n);
    const bool gone = flows_.sccm[k] < config_.lost_share * commanded_sccm_[k];
    if (!gone) gone_since_us_[k] = 0;
    if (!gone && there(n)) {
      was_there_[k] = true;
      if (flows_.fault[k] == GasFault::kFlowLost) flows_.fault[k] = GasFault::kNone;
    }
    if (!gone || !was_there_[k] || flows_.fault[k] != GasFault::kNone) continue;
    if (gone_since_us_[k] == 0) gone_since_us_[k] = now_us;
    if (double(now_us - gone_since_us_[k]) < config_.lost_s * 1e6) continue;
    stop_for(GasFault::kFlowLost, n,
             shown("%.3g of %.3g sccm flow: bottle, tube, valve?", flows_.sccm[k], commanded_sccm_[k]),
             {flows_.sccm[k] / commanded_sccm_[k], config_.lost_share, "", "gas.lost_share"});
  }
  const double kpa = flows_.kpa[kSheath];
  if (kpa <= config_.most_pressure_kpa) {
    if (flows_.fault[kSheath] == GasFault::kPressure) flows_.fault[kSheath] = GasFault::kNone;
  } else if (flows_.fault[kSheath] == GasFault::kNone) {
    stop_for(GasFault::kPressure, kSheath,
             shown("%.1f kPa behind the nozzle, gas.most_pressure_kpa = %.5g: it clogs", kpa,
                   config_.most_pressure_kpa),
             {kpa, config_.most_pressure_kpa, "kPa", "gas.most_pressure_kpa"});
  }
  fx.measured<Gas>(flows_);
}

void Gas::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  const int n = index_of(request);
  // GP07R100 says nothing to VE and answers a poll [C: alicatlib's capture].
  const bool asked_version = request.tag == kVersionTag && request.format == alicat::kVersion;
  if (asked_version) return link_.push(alicat::poll_request(unit(n), kVersionTag));
  std::string asked = "'" + std::string(alicat::text_of(request.data())) + "'";
  if (request.tag == kVersionTag) {
    const Request first = alicat::version_request(unit(n), config_.dialect, kVersionTag);
    asked = "'" + std::string(alicat::text_of(first.data())) + "' and " + asked;
  }
  const std::string why = std::string(name_of(n)) + ": unit " + std::string(1, char(request.argument)) +
                          " gives no good reply to " + asked + not_understood();
  fault(Severity::kWarning, kLinkLost, "gas: " + why, fx);
  reconnect(now_us, fx, why);
}

void Gas::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (commanded_sccm_[kAtomizer] > 0.0)
    fault(Severity::kStop, kLinkLost, "gas: link lost; the set points stay in force", fx);
  phase_ = Phase::kDown;
  finish(Outcome::kFailed, kLinkLost, "the link was lost", fx);
}

bool Gas::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kDown:
    case Phase::kRefused:
      return false;
    case Phase::kIdentifying:
    case Phase::kStopping:
      identified();
      phase_ = Phase::kReady;
      finish(Outcome::kFailed, kGas, "the atomizer's gas was ended", fx);
      set_state(DeviceState::kSafe, "no atomizer gas", fx);
      break;
    case Phase::kFirst:
    case Phase::kSecond: {
      const int n = phase_ == Phase::kFirst ? first_ : 1 - first_;
      if (round_ > 0 && there(n)) {
        if (phase_ == Phase::kFirst) {
          begin_step(Phase::kSecond, 1 - first_, now_us);
          return true;
        }
        phase_ = Phase::kReady;
        const bool flows = wanted_sccm_[kAtomizer] > 0.0;
        set_state(flows ? DeviceState::kActive : DeviceState::kSafe, flows ? "gas flows" : "no atomizer gas",
                  fx);
        finish(Outcome::kDone, kNoCode, {}, fx);
        break;
      }
      if (now_us < settle_until_us_) break;
      const std::string why =
          std::string(name_of(n)) + shown(": %.3g of %.3g sccm flow after gas.settle_s",
                                          flows_.sccm[std::size_t(n)], wanted_sccm_[std::size_t(n)]);
      const Figure figure = settled_share(n);
      fault(Severity::kStop, kGas, "gas: " + why, fx, figure);
      finish(Outcome::kFailed, kGas, why, fx, figure);
      end_atomizer(now_us, fx);
      return true;
    }
    case Phase::kReady:
      break;
  }
  if (now_us < next_read_us_) return false;
  next_read_us_ = now_us + std::int64_t(config_.poll_s * 1e6);
  for (const int n : {kAtomizer, kSheath}) link_.push(alicat::poll_request(unit(n), kReadTag));
  return true;
}

std::int64_t Gas::device_wake_us() const {
  return link_.idle() && phase_ != Phase::kDown && phase_ != Phase::kRefused ? next_read_us_ : 0;
}

void Gas::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  if (verb != "serial") return Driver::service(verb, v, now_us, fx);
  Service s{std::string(verb), {}, 0, {}, [](const Request&, std::span<const std::byte> frame) {
              const std::string_view lines = alicat::text_of(frame);
              if (alicat::is_refusal(lines)) return std::optional<std::string>();
              std::string told;
              for (const std::string_view label : {"Model Number ", "Serial Number "})
                if (const std::size_t at = lines.find(label); at != std::string_view::npos) {
                  const std::string_view value = lines.substr(at + label.size());
                  told += (told.empty() ? "" : " ") + std::string(value.substr(0, value.find('\r')));
                }
              return std::optional<std::string>(told);
            }};
  for (const int n : {kAtomizer, kSheath})
    s.begin.push_back(alicat::info_request(unit(n), config_.dialect, 0));
  run_service(std::move(s));
}

}  // namespace firn::drivers
