// Link carries requests and replies over a byte stream, as a pure state machine: one request at a time, four
// timeouts, and after any lost or damaged reply the link is suspect: it is drained until quiet, probed,
// watched once more, and only then used again, so that a late reply is never taken for the answer to a later
// question.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/link/dialect.h"
#include "drivers/link/driver_event.h"

namespace firn::drivers {

struct LinkEvent {
  enum class Kind : std::uint8_t {
    kReady,        ///< the port is open and quiet
    kReply,        ///< `frame` answers `request`
    kFailed,       ///< no good reply to `request`, and it will not be sent again; the link is suspect
    kUnsolicited,  ///< `frame` came by itself
    kSuspect,      ///< draining and probing began
    kRecovered,    ///< the link may be used again
    kLost,         ///< it could not be recovered: the port is opened anew; all requests are gone
  };
  Kind kind = Kind::kReady;
  Request request;
  std::span<const std::byte> frame;  ///< valid until the next call of the link
};

class Link {
 public:
  explicit Link(const Dialect& dialect) : dialect_(dialect) {}

  void opened(std::int64_t now_us);
  void closed();
  void received(std::span<const std::byte> bytes, std::int64_t now_us);

  /// Queues a request; it is sent by poll() when its turn comes.
  void push(const Request& request) { queue_.push_back(request); }
  /// Sends at once, ahead of the queue and even while the link is suspect: for requests that make the device
  /// safe. Its reply is awaited in order, if the link is sound. Does nothing while the port is closed.
  void urgent(const Request& request, std::int64_t now_us, Effects& fx);
  void clear_queue() {
    queue_.clear();
    head_ = 0;
  }

  /// The next event: to be called until it returns nothing. Sends and asks for a reopening through
  /// `fx`.
  std::optional<LinkEvent> poll(std::int64_t now_us, Effects& fx);

  bool is_open() const { return state_ != State::kClosed; }
  bool suspect() const {
    return state_ == State::kDraining || state_ == State::kProbing || state_ == State::kSettling;
  }
  /// Ready, with nothing queued and nothing awaited.
  bool idle() const {
    return state_ == State::kReady && head_ == queue_.size() && awaited_.empty() && failed_.empty();
  }
  /// The last line that came for an answer and was none, as shown_line(); with a note if it had no end. Kept
  /// when the port is opened anew; empty: none.
  const std::string& not_understood() const { return not_understood_; }
  std::int64_t last_sent_us() const { return last_sent_us_; }
  std::int64_t wake_us() const;  ///< 0 = no wake needed

 private:
  enum class State : std::uint8_t { kClosed, kOpening, kReady, kDraining, kProbing, kSettling };

  std::optional<LinkEvent> poll_suspect(std::int64_t now_us, Effects& fx);
  std::optional<LinkEvent> poll_awaited(std::int64_t now_us, Effects& fx);
  bool answers_a_later_one();
  std::optional<LinkEvent> ask_again(std::int64_t now_us, Effects& fx);
  void transmit(Request& request, std::int64_t now_us, Effects& fx);
  void enter_suspect(std::int64_t now_us);
  void drop_front(std::size_t bytes);
  void await(const Request& request, std::int64_t now_us);
  Frame next_frame(const Request* awaited);
  void note_unfinished();

  const Dialect& dialect_;
  State state_ = State::kClosed;
  std::vector<Request> queue_;  // [head_, end) wait
  std::size_t head_ = 0;
  std::vector<Request> awaited_;  // sent, reply to come, in order; more than one only through urgent()
  std::vector<Request> failed_;   // to be reported
  LineCleaner cleaner_;
  std::vector<std::byte> cleaned_;  // what it made of the bytes that came last
  std::vector<std::byte> rx_;
  std::string before_;  // text of the request before the awaited one
  std::string not_understood_;
  std::size_t consumed_ = 0;      // bytes of rx_ that the last event still shows
  std::int64_t deadline_us_ = 0;  // of the state, or of the reply awaited
  std::int64_t latest_us_ = 0;
  std::int64_t suspect_since_us_ = 0;
  std::int64_t last_sent_us_ = 0;
  bool announce_suspect_ = false;
};

}  // namespace firn::drivers
