#include "drivers/link/link.h"

#include <algorithm>

#include "core/options/enumerators.h"

namespace firn::drivers {
namespace {

/// The line of a corrupt frame, without its end; of a binary protocol all that has come.
std::string_view foreign_line(const Dialect& dialect, std::span<const std::byte> rx, const Frame& frame) {
  if (dialect.line_end() == 0) return text_of(rx);
  std::string_view text = text_of(rx.first(frame.size));
  if (text.ends_with(dialect.line_end())) text.remove_suffix(1);
  return text;
}

}  // namespace

const char* name(DeviceState state) {
  static constexpr const char* kNames[] = {"disconnected", "connecting", "identifying", "safe",  "staged",
                                           "armed",        "active",     "suspect",     "fault", "estop"};
  static_assert(std::size(kNames) == kTableSize<DeviceState>);
  return kNames[int(state)];
}

const char* standing(DeviceState state) {
  static constexpr const char* kWords[] = {"disconnected",
                                           "not connected yet",
                                           "not identified yet",
                                           "idle",
                                           "staged",
                                           "armed",
                                           "active",
                                           "about to be asked again after a damaged answer",
                                           "in a fault",
                                           "in an emergency stop"};
  static_assert(std::size(kWords) == kTableSize<DeviceState>);
  return kWords[int(state)];
}

const char* name(Outcome outcome) {
  static constexpr const char* kNames[] = {"ready", "done", "none", "unknown", "refused", "failed"};
  static_assert(std::size(kNames) == kTableSize<Outcome>);
  return kNames[int(outcome)];
}

void Link::opened(std::int64_t now_us) {
  closed();
  state_ = State::kOpening;
  cleaner_ = {};
  deadline_us_ = now_us + dialect_.timeouts.opening_us;
}

void Link::closed() {
  state_ = State::kClosed;
  clear_queue();
  awaited_.clear();
  failed_.clear();
  rx_.clear();
  consumed_ = 0;
  announce_suspect_ = false;
}

void Link::received(std::span<const std::byte> bytes, std::int64_t now_us) {
  drop_front(consumed_);
  consumed_ = 0;
  if (const char end = dialect_.line_end(); end != 0) {
    cleaned_.clear();
    cleaner_.clean(bytes, end, cleaned_);
    bytes = cleaned_;
    if (bytes.empty()) return;
  }
  switch (state_) {
    case State::kClosed:
      return;
    case State::kOpening:
      deadline_us_ = now_us + dialect_.timeouts.opening_us;
      return;
    case State::kDraining:
      deadline_us_ = now_us + dialect_.timeouts.quiet_us;
      return;
    case State::kSettling:  // another late reply: the probe may have been answered by it
      state_ = State::kDraining;
      deadline_us_ = now_us + dialect_.timeouts.quiet_us;
      return;
    case State::kReady:
    case State::kProbing:
      rx_.insert(rx_.end(), bytes.begin(), bytes.end());
      if (state_ == State::kProbing || !awaited_.empty())
        deadline_us_ = std::min(std::max(deadline_us_, now_us + dialect_.timeouts.read_us), latest_us_);
      return;
  }
}

void Link::await(const Request& request, std::int64_t now_us) {
  const Timeouts& t = dialect_.timeouts;
  deadline_us_ = now_us + t.write_us + (request.reply_us > 0 ? request.reply_us : t.reply_us);
  latest_us_ = deadline_us_ + t.lock_us;  // chatter must not put off the end of the wait for ever
}

void Link::transmit(Request& request, std::int64_t now_us, Effects& fx) {
  ++request.attempts;
  dialect_.write(request, fx.tx);
  last_sent_us_ = now_us;
}

void Link::urgent(const Request& request, std::int64_t now_us, Effects& fx) {
  if (state_ == State::kClosed) return;
  Request copy = request;
  transmit(copy, now_us, fx);
  if (state_ == State::kReady) {
    if (awaited_.empty()) await(copy, now_us);
    awaited_.push_back(copy);
  } else {
    state_ = state_ == State::kOpening ? State::kOpening : State::kDraining;
    deadline_us_ = std::max(deadline_us_, now_us + dialect_.timeouts.quiet_us);
  }
}

Frame Link::next_frame(const Request* awaited) {
  const Frame f = frame_of(dialect_, rx_, awaited, before_);
  if (f.kind == Frame::Kind::kCorrupt && awaited)
    not_understood_ = shown_line(foreign_line(dialect_, rx_, f));
  return f;
}

void Link::note_unfinished() {
  if (!rx_.empty()) not_understood_ = shown_line(text_of(rx_)) + ", which has no end";
}

void Link::drop_front(std::size_t bytes) { rx_.erase(rx_.begin(), rx_.begin() + std::ptrdiff_t(bytes)); }

void Link::enter_suspect(std::int64_t now_us) {
  // Requests that may be repeated go back to the head of the queue, in order; the rest is reported.
  std::vector<Request> again;
  for (const Request& r : awaited_)
    (r.repeat != Repeat::kNever && r.attempts < dialect_.max_attempts ? again : failed_).push_back(r);
  awaited_.clear();
  queue_.erase(queue_.begin(), queue_.begin() + std::ptrdiff_t(head_));
  head_ = 0;
  queue_.insert(queue_.begin(), again.begin(), again.end());
  rx_.clear();
  consumed_ = 0;
  state_ = State::kDraining;
  suspect_since_us_ = now_us;
  deadline_us_ = now_us + dialect_.timeouts.quiet_us;
  announce_suspect_ = true;
}

std::optional<LinkEvent> Link::poll_suspect(std::int64_t now_us, Effects& fx) {
  using Kind = Frame::Kind;
  if (now_us - suspect_since_us_ > dialect_.timeouts.lock_us) {
    closed();
    fx.reopen = true;
    return LinkEvent{LinkEvent::Kind::kLost, {}, {}};
  }
  if (state_ == State::kProbing && !rx_.empty()) {
    const Request probe = dialect_.probe();
    const Frame f = next_frame(&probe);
    if (f.kind == Kind::kReply && f.size == rx_.size()) {
      state_ = State::kSettling;
      deadline_us_ = now_us + dialect_.timeouts.quiet_us;
      rx_.clear();
    } else if (f.kind == Kind::kIgnore || f.kind == Kind::kUnsolicited) {
      drop_front(f.size);
      return poll_suspect(now_us, fx);
    } else if (f.kind != Kind::kIncomplete) {
      state_ = State::kDraining;
      deadline_us_ = now_us + dialect_.timeouts.quiet_us;
      rx_.clear();
    }
  }
  if (now_us < deadline_us_) return std::nullopt;
  if (state_ == State::kSettling) {
    state_ = State::kReady;
    return LinkEvent{LinkEvent::Kind::kRecovered, {}, {}};
  }
  if (state_ == State::kProbing) {  // no answer: listen again before the next probe
    note_unfinished();
    state_ = State::kDraining;
    deadline_us_ = now_us + dialect_.timeouts.quiet_us;
    rx_.clear();
    return std::nullopt;
  }
  Request probe = dialect_.probe();
  transmit(probe, now_us, fx);
  state_ = State::kProbing;
  await(probe, now_us);
  return std::nullopt;
}

// An urgent request may have overtaken others: when it is answered and they are not, they never will be.
bool Link::answers_a_later_one() {
  for (std::size_t n = 1; n < awaited_.size(); ++n) {
    if (dialect_.frame(rx_, &awaited_[n]).kind != Frame::Kind::kReply) continue;
    const auto overtaken = awaited_.begin() + std::ptrdiff_t(n);
    failed_.insert(failed_.end(), awaited_.begin(), overtaken);
    awaited_.erase(awaited_.begin(), overtaken);
    return true;
  }
  return false;
}

// An overtaken request is never sent again: it would act after the request that was to end it.
std::optional<LinkEvent> Link::ask_again(std::int64_t now_us, Effects& fx) {
  rx_.clear();  // the rest of a frame that has begun will not come any more
  if (awaited_.size() > 1) {
    failed_.push_back(awaited_.front());
    awaited_.erase(awaited_.begin());
    await(awaited_.front(), now_us);
    return std::nullopt;
  }
  if (awaited_.front().attempts < dialect_.max_attempts) {
    transmit(awaited_.front(), now_us, fx);
    await(awaited_.front(), now_us);
    return std::nullopt;
  }
  closed();
  fx.reopen = true;
  return LinkEvent{LinkEvent::Kind::kLost, {}, {}};
}

std::optional<LinkEvent> Link::poll_awaited(std::int64_t now_us, Effects& fx) {
  using Kind = Frame::Kind;
  while (!rx_.empty()) {
    const Frame f = next_frame(awaited_.empty() ? nullptr : &awaited_.front());
    if (f.kind == Kind::kIncomplete) break;
    if (f.kind == Kind::kCorrupt) {
      if (awaited_.empty() || dialect_.numbered) {  // noise while nobody asks does no harm
        drop_front(f.size);
        continue;
      }
      enter_suspect(now_us);
      return std::nullopt;
    }
    if (f.kind == Kind::kIgnore) {
      if (dialect_.numbered && answers_a_later_one()) continue;
      drop_front(f.size);
      continue;
    }
    LinkEvent e{LinkEvent::Kind::kUnsolicited, {}, std::span(rx_).first(f.size)};
    consumed_ = f.size;
    if (f.kind == Kind::kReply) {
      e.kind = LinkEvent::Kind::kReply;
      e.request = awaited_.front();
      before_ = e.request.text();
      awaited_.erase(awaited_.begin());
      if (!awaited_.empty()) await(awaited_.front(), now_us);
    }
    return e;
  }
  if (awaited_.empty() || now_us < deadline_us_) return std::nullopt;
  note_unfinished();
  if (dialect_.numbered) return ask_again(now_us, fx);
  enter_suspect(now_us);
  return std::nullopt;
}

std::optional<LinkEvent> Link::poll(std::int64_t now_us, Effects& fx) {
  drop_front(consumed_);
  consumed_ = 0;
  if (state_ == State::kClosed) return std::nullopt;
  if (state_ == State::kOpening) {
    if (now_us < deadline_us_) return std::nullopt;
    state_ = State::kReady;
    rx_.clear();
    return LinkEvent{LinkEvent::Kind::kReady, {}, {}};
  }
  if (state_ == State::kReady) {
    if (auto e = poll_awaited(now_us, fx)) return e;
  }
  if (announce_suspect_) {
    announce_suspect_ = false;
    return LinkEvent{LinkEvent::Kind::kSuspect, {}, {}};
  }
  if (!failed_.empty()) {
    LinkEvent e{LinkEvent::Kind::kFailed, failed_.front(), {}};
    failed_.erase(failed_.begin());
    return e;
  }
  if (suspect()) return poll_suspect(now_us, fx);
  if (awaited_.empty() && head_ < queue_.size()) {
    awaited_.push_back(queue_[head_++]);
    if (head_ == queue_.size()) clear_queue();
    transmit(awaited_.back(), now_us, fx);
    await(awaited_.back(), now_us);
  }
  return std::nullopt;
}

std::int64_t Link::wake_us() const {
  if (state_ == State::kClosed) return 0;
  if (state_ == State::kReady && awaited_.empty()) return 0;
  if (suspect()) return std::min(deadline_us_, suspect_since_us_ + dialect_.timeouts.lock_us + 1);
  return deadline_us_;
}

}  // namespace firn::drivers
