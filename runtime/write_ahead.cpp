#include "runtime/write_ahead.h"

#include <cstring>
#include <stdexcept>

namespace firn {
namespace {

class Put {
 public:
  explicit Put(std::vector<std::byte>& to) : to_(to) {}
  template <class T>
  void number(T v) {
    const std::size_t at = to_.size();
    to_.resize(at + sizeof v);
    std::memcpy(to_.data() + at, &v, sizeof v);
  }
  void bytes(std::span<const std::byte> b) {
    number(std::uint32_t(b.size()));
    to_.insert(to_.end(), b.begin(), b.end());
  }
  void text(std::string_view s) { bytes(std::as_bytes(std::span(s))); }

 private:
  std::vector<std::byte>& to_;
};

class Take {
 public:
  explicit Take(std::span<const std::byte> from) : from_(from) {}
  template <class T>
  T number() {
    T v;
    std::memcpy(&v, need(sizeof v).data(), sizeof v);
    return v;
  }
  std::span<const std::byte> bytes() { return need(number<std::uint32_t>()); }
  std::string_view text() {
    const auto b = bytes();
    return {reinterpret_cast<const char*>(b.data()), b.size()};
  }
  std::size_t at() const { return at_; }
  bool done() const { return at_ == from_.size(); }
  std::span<const std::byte> rest() const { return from_.subspan(at_); }

 private:
  std::span<const std::byte> need(std::size_t n) {
    if (n > from_.size() - at_)
      throw std::runtime_error("write-ahead record: byte " + std::to_string(at_) + ": " + std::to_string(n) +
                               " bytes wanted, " + std::to_string(from_.size() - at_) + " left");
    const auto s = from_.subspan(at_, n);
    at_ += n;
    return s;
  }
  std::span<const std::byte> from_;
  std::size_t at_ = 0;
};

std::int32_t incarnation(Take& take) {
  const auto v = take.number<std::int32_t>();
  if (v < 0 || v > kLastIncarnation)
    throw std::runtime_error("write-ahead record: byte " + std::to_string(take.at() - sizeof v) +
                             ": incarnation " + std::to_string(v) + " is not in [0, " +
                             std::to_string(kLastIncarnation) + "]");
  return v;
}

LinkState link_state(Take& take) {
  const auto state = take.number<std::uint8_t>();
  if (state > 1)
    throw std::runtime_error("write-ahead record: byte " + std::to_string(take.at() - 1) + ": link state " +
                             std::to_string(state) + " is not known");
  return state ? LinkState::kOpen : LinkState::kClosed;
}

void put_output(Put& put, const Output& o) {
  put.number(std::uint8_t(o.kind));
  switch (o.kind) {
    case OutputKind::kSend:
      put.text(o.channel);
      put.bytes(o.bytes);
      break;
    case OutputKind::kArm:
      put.number(o.id);
      put.number(o.at.us);
      break;
    case OutputKind::kCancel:
    case OutputKind::kReopen:
      put.number(o.id);
      break;
    case OutputKind::kWrite:
    case OutputKind::kFinish:
      put.number(o.id);
      put.bytes(o.bytes);
      break;
  }
}

}  // namespace

void encode_head(const WalHead& h, std::vector<std::byte>& to) {
  Put put(to);
  put.text(h.node);
  put.number(h.run_id);
  put.number(h.incarnation);
  put.text(h.commit);
  put.text(h.platform);
  put.text(h.config_toml);
  put.text(h.type_texts);
  put.number(std::uint32_t(h.blobs.size()));
  for (const auto& [role, sha] : h.blobs) {
    put.text(role);
    put.text(sha);
  }
}

WalHead decode_head(std::span<const std::byte> payload) {
  Take take(payload);
  WalHead h;
  h.node = take.text();
  h.run_id = take.number<std::int64_t>();
  h.incarnation = incarnation(take);
  h.commit = take.text();
  h.platform = take.text();
  h.config_toml = take.text();
  h.type_texts = take.text();
  for (auto n = take.number<std::uint32_t>(); n > 0; --n) {
    std::string role(take.text());
    h.blobs.emplace_back(std::move(role), std::string(take.text()));
  }
  return h;
}

void encode_event(std::uint64_t step, const Event& e, std::vector<std::byte>& to) {
  Put put(to);
  put.number(step);
  put.number(std::uint8_t(e.kind));
  put.number(e.now.us);
  switch (e.kind) {
    case EventKind::kStart:
      put.number(e.incarnation);
      break;
    case EventKind::kMessage:
      put.text(e.channel);
      put.bytes(e.bytes);
      break;
    case EventKind::kWake:
      put.number(e.id);
      put.number(e.due.us);
      break;
    case EventKind::kIo:
    case EventKind::kRefused:
      put.number(e.id);
      put.bytes(e.bytes);
      break;
    case EventKind::kLink:
      put.number(e.id);
      put.number(std::uint8_t(e.link));
      break;
    case EventKind::kLocalStop:
      put.bytes(e.bytes);
      break;
  }
}

WalEvent decode_event(std::span<const std::byte> payload) {
  Take take(payload);
  WalEvent w;
  w.step = take.number<std::uint64_t>();
  const auto kind = take.number<std::uint8_t>();
  Event& e = w.event;
  e.kind = EventKind(kind);
  e.now.us = take.number<std::int64_t>();
  switch (e.kind) {
    case EventKind::kStart:
      e.incarnation = incarnation(take);
      break;
    case EventKind::kMessage:
      e.channel = take.text();
      e.bytes = take.bytes();
      break;
    case EventKind::kWake:
      e.id = take.number<std::uint32_t>();
      e.due.us = take.number<std::int64_t>();
      break;
    case EventKind::kIo:
    case EventKind::kRefused:
      e.id = take.number<std::uint32_t>();
      e.bytes = take.bytes();
      break;
    case EventKind::kLink:
      e.id = take.number<std::uint32_t>();
      e.link = link_state(take);
      break;
    case EventKind::kLocalStop:
      e.bytes = take.bytes();
      break;
    default:
      throw std::runtime_error("write-ahead record: byte 8: event kind " + std::to_string(kind) +
                               " is not known");
  }
  return w;
}

void encode_output_list(const Outbox& outbox, std::vector<std::byte>& to) {
  Put put(to);
  put.number(std::uint32_t(outbox.size()));
  for (std::size_t n = 0; n < outbox.size(); ++n) put_output(put, outbox.at(n));
}

void encode_outputs(std::uint64_t step, std::int64_t handler_ns, const Outbox& outbox,
                    std::vector<std::byte>& to) {
  Put put(to);
  put.number(step);
  put.number(handler_ns);
  encode_output_list(outbox, to);
}

WalOutputs decode_outputs(std::span<const std::byte> payload) {
  Take take(payload);
  WalOutputs w;
  w.step = take.number<std::uint64_t>();
  w.handler_ns = take.number<std::int64_t>();
  w.body = take.rest();
  return w;
}

std::vector<Output> decode_output_list(std::span<const std::byte> body) {
  std::vector<Output> list;
  decode_output_list(body, list);
  return list;
}

void decode_output_list(std::span<const std::byte> body, std::vector<Output>& list) {
  list.clear();
  Take take(body);
  for (auto n = take.number<std::uint32_t>(); n > 0; --n) {
    Output o;
    const auto kind = take.number<std::uint8_t>();
    o.kind = OutputKind(kind);
    switch (o.kind) {
      case OutputKind::kSend:
        o.channel = take.text();
        o.bytes = take.bytes();
        break;
      case OutputKind::kArm:
        o.id = take.number<std::uint32_t>();
        o.at.us = take.number<std::int64_t>();
        break;
      case OutputKind::kCancel:
      case OutputKind::kReopen:
        o.id = take.number<std::uint32_t>();
        break;
      case OutputKind::kWrite:
      case OutputKind::kFinish:
        o.id = take.number<std::uint32_t>();
        o.bytes = take.bytes();
        break;
      default:
        throw std::runtime_error("write-ahead record: byte " + std::to_string(take.at()) + ": output kind " +
                                 std::to_string(kind) + " is not known");
    }
    list.push_back(o);
  }
  if (!take.done())
    throw std::runtime_error("write-ahead record: byte " + std::to_string(take.at()) + ": bytes left over");
}

}  // namespace firn
