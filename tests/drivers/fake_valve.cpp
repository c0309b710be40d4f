#include "tests/drivers/fake_valve.h"
#include "tests/support/valve_firmware.h"

namespace firn::drivers::test {

using fvb::Type;

void FakeValve::reboot() {
  ++status.boot_count;
  status.state = fvb::State::kIdle;
  status.next = 0;
  status.path = 0;
  list.clear();
  last_seq_ = 0;
}

void FakeValve::trigger(std::int64_t now_us) {
  if (status.state != fvb::State::kArmed) return;
  status.state = fvb::State::kFiring;
  trigger_us_ = now_us;
}

void FakeValve::advance(std::int64_t now_us) {
  if (status.state != fvb::State::kFiring) return;
  const std::int64_t end_us = std::min(now_us, heard_us_ + 2'000'000);  // two seconds without its host
  while (status.next < list.size()) {
    const auto at = trigger_us_ + std::int64_t(double(list[status.next]) * begin_.tick_us / clock);
    if (at > end_us) break;
    shots_us.push_back(at);
    ++status.next;
  }
  status.since_us = std::uint32_t(double(end_us - trigger_us_) * clock);
  if (status.next == list.size() || end_us < now_us) status.state = fvb::State::kDone;
}

void FakeValve::answer(Type type, std::uint8_t seq, int refusal) {
  std::vector<std::byte> reply;
  if (refusal)
    fvb::encode_nak(seq, status.boot_count, fvb::Refusal(refusal), reply);
  else if (type == Type::kHello)
    fvb::encode(seq, fvb::Hello{status.boot_count, 3, 0}, reply);
  else if (type == Type::kStatus)
    fvb::encode(seq, status, reply);
  else
    fvb::encode_ack(seq, status.boot_count, reply);
  last_reply_.assign(reinterpret_cast<const char*>(reply.data()), reply.size());
  out += last_reply_;
}

void FakeValve::take(std::string_view bytes, std::int64_t now_us) {
  advance(now_us);
  held_ += bytes;
  while (!held_.empty()) {
    const fvb::Found f = fvb::find(std::as_bytes(std::span(held_.data(), held_.size())));
    if (f.kind == fvb::Found::Kind::kIncomplete) return;
    if (f.kind == fvb::Found::Kind::kFrame) {
      heard_us_ = now_us;
      if (f.type != Type::kHello && f.seq == last_seq_)
        out += last_reply_;
      else if (f.type != Type::kHello && !fvb::newer(f.seq, last_seq_))
        answer(f.type, f.seq, 11);
      else
        execute(f, now_us);
    }
    held_.erase(0, f.size);
  }
}

void FakeValve::execute(const fvb::Found& f, std::int64_t now_us) {
  requests.push_back(f.type);
  last_seq_ = f.seq;
  int refusal = 0;
  switch (f.type) {
    case Type::kBegin:
      begin_ = fvb::parse_begin(f.payload).value();
      if (status.state == fvb::State::kArmed || status.state == fvb::State::kFiring) {
        refusal = 20;
        break;
      }
      list.clear();
      status.state = fvb::State::kLoading;
      status.path = begin_.path;
      status.next = 0;
      break;
    case Type::kData: {
      const auto d = fvb::parse_data(f.payload).value();
      if (d.offset != list.size()) refusal = 22;
      for (std::size_t n = 0; n < d.entries && !refusal; ++n) list.push_back(d.tick(n));
      break;
    }
    case Type::kEnd:
      if (list.size() != begin_.entries || fvb::parse_number(f.payload) != fvb::list_crc(list) ||
          corrupt_ends-- > 0)
        refusal = 23;
      else
        status.state = fvb::State::kLoaded;
      break;
    case Type::kArm:
      if (status.state != fvb::State::kLoaded)
        refusal = 20;
      else
        status.state = fvb::State::kArmed;
      break;
    case Type::kDisarm:
      if (status.state == fvb::State::kArmed) status.state = fvb::State::kLoaded;
      if (status.state == fvb::State::kFiring) status.state = fvb::State::kDone;
      break;
    case Type::kAbort:
      status.state = fvb::State::kIdle;
      list.clear();
      break;
    default:
      break;
  }
  answer(f.type, f.seq, refusal);
}

}  // namespace firn::drivers::test
