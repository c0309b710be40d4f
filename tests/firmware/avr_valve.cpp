#include "tests/firmware/avr_valve.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn::test {
namespace {

using plant::FiringEnd;
using plant::kNever;
namespace fvb = plant::fvb;

constexpr std::int64_t kStep_us = 400, kLinePulse_us = 1000;
constexpr std::uint64_t kLongest_cycles = 60'000 * AvrBox::kCyclesOfAUs;  // no pulse is longer
constexpr std::int64_t kSilence_us = 60'000;  ///< after which a box without an armed list stands still

}  // namespace

AvrValve::AvrValve(const std::string& elf, int valve, const plant::IceValveParams& params,
                   plant::IceWires& wires)
    : ValveBox(valve == 0 ? plant::Port::kValveA : plant::Port::kValveB,
               plant::TwinLink(10.0e6 / params.baud, 0)),
      elf_(elf),
      valve_(valve),
      params_(params),
      wires_(wires) {
  start(0, {});
}

void AvrValve::start(std::int64_t now_us, std::vector<std::uint8_t> eeprom) {
  box_ = std::make_unique<AvrBox>(elf_, std::move(eeprom));
  base_us_ = ran_us_ = stirred_us_ = now_us;
  base_cycle_ = opened_ = 0;
  awake_ = true;
  armed_ = false;
  rises_us_ = falls_us_ = enables_us_ = kNever;
  from_host_.clear();
  from_box_.clear();
  list_.reset();
  over_.reset();
}

double AvrValve::us_at(std::uint64_t cycle) const {
  return double(base_us_) +
         double(cycle - base_cycle_) / double(AvrBox::kCyclesOfAUs) * (1.0 + params_.clock_ppm * 1e-6);
}

std::uint64_t AvrValve::cycle_at(std::int64_t now_us) const {
  return base_cycle_ + std::uint64_t(std::llround(double(now_us - base_us_) * double(AvrBox::kCyclesOfAUs) /
                                                  (1.0 + params_.clock_ppm * 1e-6)));
}

void AvrValve::wake(std::int64_t now_us) {
  stirred_us_ = now_us;
  if (awake_) return run_until(now_us);
  awake_ = true;
  base_us_ = ran_us_ = now_us;
  base_cycle_ = box_->cycle();
}

// A pulse that is open is run to its end, which may be in the world's future: nature takes a pulse with its
// length. Bytes that come meanwhile wait for that end.
void AvrValve::run_until(std::int64_t now_us) {
  if (!awake_) return;
  const std::uint64_t until = cycle_at(now_us);
  while (box_->cycle() < until || opened_ != 0) {
    box_->run_to_edge(opened_ != 0 ? box_->cycle() + kLongest_cycles : until);
    see_edges();
  }
  ran_us_ = now_us;
  hear_box(now_us);
}

void AvrValve::see_edges() {
  for (const AvrBox::Edge& e : box_->edges) {
    if (!e.hold) continue;
    if (e.high) {
      opened_ = e.cycle;
    } else if (opened_ != 0) {
      pulse(std::exchange(opened_, 0), e.cycle);
    }
  }
  box_->edges.clear();
}

void AvrValve::pulse(std::uint64_t opened, std::uint64_t closed) {
  const double at_us = us_at(opened);
  if (!list_) list_ = List{std::int64_t(at_us), 0, 0, 0, 0.0};
  if (!counted_) list_->volume_mm3 += wires_.nature().firing(valve_).volume_mm3;
  counted_ = false;
  list_->last_us = std::llround(at_us);
  if (list_->pulses++ == 0) list_->first_us = list_->last_us;
  plant::Firing one;
  one.path = head_.path;
  one.tick_s = 1.0;
  one.pulse_s = (us_at(closed) - at_us) * 1e-6;
  one.ticks = {0};
  wires_.nature().trigger_valve(valve_, at_us * 1e-6, std::move(one));
  if (list_->pulses == head_.entries) {
    over_ = FiringEnd::kThrough;
    armed_ = false;
  }
}

void AvrValve::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  wake(now_us);
  box_->give(bytes);
  from_host_.insert(from_host_.end(), bytes.begin(), bytes.end());
  hear_host();
}

void AvrValve::hear_host() {
  for (;;) {
    const fvb::Intake in = fvb::take_in(from_host_);
    if (in.size == 0) return;
    if (in.good) {
      asked_[in.number] = in.kind;
      if (in.kind == fvb::Kind::kBegin || in.kind == fvb::Kind::kSpit)
        head_ = fvb::head_of(in.payload).value_or(head_);
    }
    from_host_.erase(from_host_.begin(), from_host_.begin() + std::ptrdiff_t(in.size));
  }
}

void AvrValve::hear_box(std::int64_t now_us) {
  const std::string bytes = box_->take_sent();
  if (bytes.empty()) return;
  stirred_us_ = now_us;
  link_.reply(bytes, now_us);
  for (const char c : bytes) from_box_.push_back(std::byte(c));
  for (;;) {
    const fvb::Intake in = fvb::take_in(from_box_);
    if (in.size == 0) return;
    constexpr std::size_t kState = 2;  // of STATUS, behind the boot count
    const bool faulty = in.good && in.kind == fvb::Kind::kStatus && in.payload.size() > kState &&
                        in.payload[kState] == std::byte(fvb::State::kFault);
    if (faulty && list_ && !over_) over_ = FiringEnd::kWatchdog;
    if (faulty) armed_ = false;
    if (in.good && in.kind == fvb::Kind::kAck) {
      const fvb::Kind asked = asked_[in.number];
      if (asked == fvb::Kind::kArm && !std::exchange(armed_, true))
        wires_.note(now_us, port_, plant::DeviceEvent::kValveArmed, head_.path);
      if (asked == fvb::Kind::kDisarm || asked == fvb::Kind::kAbort) {
        armed_ = false;
        if (list_ && !over_) over_ = asked == fvb::Kind::kDisarm ? FiringEnd::kDisarmed : FiringEnd::kAborted;
      }
    }
    from_box_.erase(from_box_.begin(), from_box_.begin() + std::ptrdiff_t(in.size));
  }
}

// One step later, when nature has let the last drop fall.
void AvrValve::settle(std::int64_t now_us) {
  if (!over_ || !list_ || now_us <= list_->last_us) return;
  const plant::Firing last = wires_.nature().close_valve(valve_);
  if (!counted_) list_->volume_mm3 += last.volume_mm3;
  counted_ = true;
  wires_.fired({list_->triggered_us,
                list_->first_us,
                list_->last_us,
                now_us,
                list_->volume_mm3,
                head_.path,
                head_.entries,
                list_->pulses,
                std::uint8_t(valve_),
                *over_,
                {}});
  list_.reset();
  over_.reset();
}

void AvrValve::signal(std::int64_t t_us) {
  wake(t_us);
  signalled_us_ = t_us;
  rises_us_ = t_us + std::llround(params_.trigger_delay_s * 1e6);
}

void AvrValve::disable(std::int64_t t_us) {
  wake(t_us);
  rises_us_ = kNever;
  box_->enable(false);
  enables_us_ = t_us + kLinePulse_us;
  armed_ = false;
  if (list_ && !over_) over_ = FiringEnd::kDisabled;
}

std::int64_t AvrValve::next_device_us() const {
  const std::int64_t pin_us = std::min({rises_us_, falls_us_, enables_us_});
  return awake_ ? std::min(pin_us, ran_us_ + kStep_us) : pin_us;
}

void AvrValve::device_event(std::int64_t now_us) {
  settle(now_us);
  run_until(now_us);
  if (now_us == rises_us_) {
    rises_us_ = kNever;
    falls_us_ = now_us + kLinePulse_us;
    box_->signal(true);
    if (armed_ && !list_) list_ = List{signalled_us_, 0, 0, 0, 0.0};
  }
  if (now_us == falls_us_) {
    falls_us_ = kNever;
    box_->signal(false);
  }
  if (now_us == enables_us_) {
    enables_us_ = kNever;
    box_->enable(true);
  }
  const bool rests = !armed_ && !list_ && next_device_us() == ran_us_ + kStep_us;
  if (rests && now_us - stirred_us_ > kSilence_us) awake_ = false;
}

void AvrValve::trip(std::int64_t, std::int64_t code) { plant::trip_line(wires_.nature(), valve_, code); }

void AvrValve::reboot(std::int64_t now_us) {
  run_until(now_us);
  if (list_ && !over_) over_ = FiringEnd::kReboot;
  settle(now_us);
  ++boot_count_;
  start(now_us, box_->eeprom());
  wires_.note(now_us, port_, plant::DeviceEvent::kRebooted, boot_count_);
}

void AvrValve::io(plant::Archive& a) {
  std::vector<std::uint8_t> kept = box_->eeprom();
  a.all(boot_count_, kept, stirred_us_, link_);
  if (a.loading()) start(stirred_us_, std::move(kept));
}

}  // namespace firn::test
