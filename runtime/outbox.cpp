#include "runtime/outbox.h"

#include <cstring>
#include <utility>

#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {

void Outbox::begin(Time now, std::int32_t incarnation) {
  now_ = now;
  incarnation_ = incarnation;
  durable_ = false;
  entries_.clear();
  arena_.clear();
}

Output Outbox::at(std::size_t n) const {
  const Entry& e = entries_[n];
  return {e.kind, e.channel, e.id, e.at, std::span(arena_).subspan(e.offset, e.size)};
}

std::int64_t Outbox::next_seq(std::string_view channel) {
  auto it = last_seq_.find(channel);
  if (it == last_seq_.end()) {
    const ChannelInfo* row = find_channel(channel);
    if (!row) throw std::logic_error("channel " + std::string(channel) + " is not in the channel table");
    if (row->publisher != node_)
      throw std::logic_error(std::string(info(node_).name) + " must not publish " + std::string(channel) +
                             ", which is " + std::string(info(row->publisher).name) + "'s");
    it = last_seq_.emplace(row->name, 0).first;
  }
  return ++it->second;
}

void Outbox::resume_after(std::string_view channel, std::int64_t seq) {
  next_seq(channel);
  last_seq_.find(channel)->second = seq;
}

std::span<std::byte> Outbox::reserve(std::size_t size) {
  const std::size_t at = arena_.size();
  arena_.resize(at + size);
  return std::span(arena_).subspan(at, size);
}

void Outbox::push_send(std::string_view channel, std::size_t size) {
  entries_.push_back(
      {OutputKind::kSend, last_seq_.find(channel)->first, 0, Time{}, arena_.size() - size, size});
}

void Outbox::push(OutputKind kind, std::string_view channel, std::uint32_t id, Time at,
                  std::span<const std::byte> bytes) {
  const std::span<std::byte> place = reserve(bytes.size());
  if (!bytes.empty()) std::memcpy(place.data(), bytes.data(), bytes.size());
  entries_.push_back({kind, channel, id, at, arena_.size() - bytes.size(), bytes.size()});
}

void Outbox::report(Severity severity, std::string text, std::int32_t code, const Figure& figure) {
  fault_t f{};
  f.severity = std::int8_t(severity);
  f.code = code;
  f.node = info(node_).name;
  f.text = std::move(text);
  f.figure = to_message(figure);
  send(channels::fault(node_), std::move(f));
}

void Outbox::warn(std::string text) { report(Severity::kWarning, std::move(text)); }

void Outbox::wake_at(TimerId t, Time at) { push(OutputKind::kArm, {}, std::uint32_t(t), at, {}); }
void Outbox::cancel(TimerId t) { push(OutputKind::kCancel, {}, std::uint32_t(t), {}, {}); }
void Outbox::write(PortId p, std::span<const std::byte> bytes) {
  push(OutputKind::kWrite, {}, std::uint32_t(p), {}, bytes);
}
void Outbox::reopen(PortId p) { push(OutputKind::kReopen, {}, std::uint32_t(p), {}, {}); }
void Outbox::finish(int status, std::string_view reason) {
  push(OutputKind::kFinish, {}, std::uint32_t(status), {}, std::as_bytes(std::span(reason)));
}

}  // namespace firn
