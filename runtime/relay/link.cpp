#include "runtime/relay/link.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>

#include "runtime/run_clock.h"

namespace firn::relay {
namespace {

constexpr std::size_t kReadBytes = 64 << 10, kReadsAtOnce = 16;
constexpr std::size_t kWriteBytes = 64 << 10;
constexpr std::int64_t kTellTakenBytes = 16 << 10, kTellTakenNs = 10'000'000;

void never_wait(int fd) {
  ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
  ::fcntl(fd, F_SETFD, FD_CLOEXEC);
}

}  // namespace

Link::Lane::Lane(int in_fd, int out_fd) : in(in_fd), out(out_fd < 0 ? in_fd : out_fd) {
  never_wait(in);
  never_wait(out);
}

Link::Lane::~Lane() {
  ::close(in);
  if (out != in) ::close(out);
}

Link::Link(int in_fd, int out_fd) : heard_ns_(monotonic_ns()) {
  lanes_.push_back(std::make_unique<Lane>(in_fd, out_fd));
}

Link::~Link() = default;

void Link::add_lane(int fd) { lanes_.push_back(std::make_unique<Lane>(fd, -1)); }

bool Link::closed() const { return lanes_.front()->closed; }

void Link::send(const Frame& frame) {
  lanes_.front()->queue.add(frame);
  if (frame.kind == FrameKind::kHello || goes_in_turn(frame)) return;
  for (std::size_t n = 1; n < lanes_.size(); ++n) lanes_[n]->queue.add(frame);
}

void Link::say(std::string_view process, std::string_view line) {
  send({FrameKind::kLine, process, ++lines_sent_, 0, std::as_bytes(std::span(line))});
}

void Link::say_behind_files(std::string_view line) {
  lanes_.front()->queue.add({FrameKind::kLine, {}, 0, 0, std::as_bytes(std::span(line))});
}

void Link::set_files(SendQueue::NextFile files) { lanes_.front()->queue.set_files(std::move(files)); }

void Link::rest() const {
  const std::int64_t early = serviced_ns_ + kCalmNs - monotonic_ns();
  if (early <= 0) return;
  const timespec pause{0, long(early)};
  ::nanosleep(&pause, nullptr);
}

void Link::service(const Take& take) {
  serviced_ns_ = monotonic_ns();
  for (std::size_t n = 0; n < lanes_.size(); ++n) read(*lanes_[n], take);  // which may add a lane
  const std::int64_t now = monotonic_ns();
  if (asks_ && now >= ask_at_ns()) {
    asked_ns_ = now;
    ++asks_made_;
    for (const auto& lane : lanes_) lane->queue.add({FrameKind::kAsk, {}, now, 0, {}});
  }
  for (const auto& lane : lanes_) {
    if (lane->taken - lane->told_taken >= kTellTakenBytes ||
        (lane->taken > lane->told_taken && now >= lane->told_ns + kTellTakenNs)) {
      lane->told_taken = lane->taken;
      lane->told_ns = now;
      lane->queue.add({FrameKind::kTaken, {}, lane->taken, 0, {}});
    }
    write(*lane);
  }
  std::erase_if(lanes_, [&](const auto& lane) { return lane != lanes_.front() && lane->closed; });
}

void Link::read(Lane& lane, const Take& take) {
  std::byte bytes[kReadBytes];
  for (std::size_t n = 0; n < kReadsAtOnce && !lane.closed; ++n) {
    const ssize_t got = ::read(lane.in, bytes, sizeof bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) return;
    if (got <= 0) lane.closed = true;
    if (got > 0) {
      heard_ns_ = monotonic_ns();
      lane.reader.add({bytes, std::size_t(got)});
    }
    while (const auto frame = lane.reader.next()) handle(lane, *frame, take);
  }
}

void Link::handle(Lane& lane, const Frame& frame, const Take& take) {
  const std::int64_t now = monotonic_ns();
  switch (frame.kind) {
    case FrameKind::kAsk:
      lane.queue.add({FrameKind::kTell, {}, frame.number, now, {}});
      return write(lane);  // before anything else: time in between widens the bound
    case FrameKind::kTell:
      clock_.add(frame.number, frame.second, now);
      if (const auto e = clock_.at(now)) lane.queue.set_round_trip_ns(e->quickest_ns);
      return;
    case FrameKind::kTaken:
      return lane.queue.taken(frame.number, now);
    case FrameKind::kLine:
      if (frame.number == 0) return take(frame);     // behind files
      if (frame.number != lines_taken_ + 1) return;  // it came by another lane before
      ++lines_taken_;
      return take(frame);
    case FrameKind::kDatagram:
    case FrameKind::kFile:
      lane.taken += std::int64_t(wire_bytes(frame));
      return take(frame);
    case FrameKind::kPort:
      if (goes_in_turn(frame)) lane.taken += std::int64_t(wire_bytes(frame));
      return take(frame);
    case FrameKind::kHello:
      return take(frame);
  }
}

void Link::write(Lane& lane) {
  while (!lane.closed) {
    if (lane.left == lane.leaving.size()) {
      lane.leaving.clear();
      lane.left = 0;
      if (!lane.queue.next(monotonic_ns(), kWriteBytes, lane.leaving)) return;
    }
    const ssize_t sent = ::write(lane.out, lane.leaving.data() + lane.left, lane.leaving.size() - lane.left);
    if (sent > 0) {
      lane.left += std::size_t(sent);
    } else if (errno != EINTR) {
      if (errno != EAGAIN) lane.closed = true;
      return;
    }
  }
}

void Link::add_to(std::vector<pollfd>& fds) const {
  for (const auto& lane : lanes_) {
    if (!lane->closed) fds.push_back({lane->in, POLLIN, 0});
    if (lane->left < lane->leaving.size()) fds.push_back({lane->out, POLLOUT, 0});
  }
}

std::int64_t Link::due_us() const {
  std::int64_t due = asks_ ? ask_at_ns() : INT64_MAX;
  for (const auto& lane : lanes_)
    if (lane->taken > lane->told_taken) due = std::min(due, lane->told_ns + kTellTakenNs);
  return due == INT64_MAX ? due : due / 1000 + 1;
}

double Link::silent_s() const { return double(monotonic_ns() - heard_ns_) * 1e-9; }

}  // namespace firn::relay
