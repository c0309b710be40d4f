// Holds two small nodes and a bus without a network, to run processes in tests.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "firn/answer_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enums.h"
#include "firn/jet_command_t.hpp"
#include "runtime/bus.h"
#include "runtime/node.h"

namespace firn::test {

/// Sends a command every millisecond; stops after `most` answers.
class Commander : public Node {
 public:
  explicit Commander(int most) : most_(most) { subscribe(channels::answer(NodeId::kJet), this); }
  void start(const Start&, Time now, Outbox& out) override { out.wake_at(TimerId{0}, now.after_s(1e-3)); }
  void wake(TimerId, Time now, Outbox& out) override {
    jet_command_t c{};
    c.command_id = ++sent_;
    c.verb = std::int8_t(JetVerb::kArm);
    out.send(channels::kJetCommand, c);
    out.durable();
    if (sent_ < most_) out.wake_at(TimerId{0}, now.after_s(1e-3));
  }
  void on(const answer_t& a, Time, Outbox& out) {
    if (a.text == "throw") throw std::runtime_error("the commander cannot take this");
    if (++answers_ == most_) out.finish(0, "all answered");
  }
  std::int64_t sent_ = 0;
  std::int64_t answers_ = 0;
  int most_;
};

/// A driver: passes each command on to its instrument as one byte, answers when the byte comes back.
class Echo : public Node {
 public:
  Echo() { subscribe(channels::kJetCommand, this); }
  std::vector<std::string> ports() const override { return {"jet"}; }
  void on_link(PortId, LinkState link, Time, Outbox& out) override {
    open_ = link == LinkState::kOpen;
    state(open_ ? DeviceState::kSafe : DeviceState::kDisconnected, out);
    if (open_)
      for (const std::int64_t id : waiting_) ask(id, out);
    else
      out.reopen(PortId{0});
  }
  void on(const jet_command_t& c, Time, Outbox& out) {
    waiting_.push_back(c.command_id);
    if (open_) ask(c.command_id, out);
  }
  void on_io(PortId, std::span<const std::byte> bytes, Time, Outbox& out) override {
    for (std::size_t n = 0; n < bytes.size() && !waiting_.empty(); ++n) {
      answer_t a{};
      a.node = "jet";
      a.command_id = waiting_.front();
      waiting_.pop_front();
      out.send(channels::answer(NodeId::kJet), a);
    }
  }
  void local_stop(std::string_view cause, Time, Outbox& out) override {
    text_ = cause;
    state(DeviceState::kSafe, out);
  }

 private:
  void ask(std::int64_t id, Outbox& out) {
    const std::byte b{std::uint8_t(id)};
    out.write(PortId{0}, {&b, 1});
  }
  void state(DeviceState s, Outbox& out) {
    device_state_t m{};
    m.node = "jet";
    m.state = std::int8_t(s);
    m.text = text_;
    out.send(channels::device_state(NodeId::kJet), m);
  }
  std::deque<std::int64_t> waiting_;
  bool open_ = false;
  std::string text_;
};

/// Hands datagrams to all other members of one process, by threads.
class Hub {
 public:
  class Member : public Bus {
   public:
    explicit Member(Hub& hub) : hub_(hub), fd_(::eventfd(0, EFD_NONBLOCK)) {
      const std::lock_guard lock(hub_.mutex_);
      hub_.members_.insert(this);
    }
    ~Member() override {
      const std::lock_guard lock(hub_.mutex_);
      hub_.members_.erase(this);
      ::close(fd_);
    }
    void subscribe(const std::string& channel) override {
      const std::lock_guard lock(hub_.mutex_);
      channels_.insert(channel);
    }
    int fd() const override { return fd_; }
    void receive(const Sink& sink) override {
      std::uint64_t count;
      if (::read(fd_, &count, sizeof count) < 0) return;
      std::deque<std::pair<std::string, std::vector<std::byte>>> got;
      {
        const std::lock_guard lock(hub_.mutex_);
        got.swap(inbox_);
      }
      for (const auto& [channel, bytes] : got) sink(channel, bytes);
    }
    void publish(std::string_view channel, std::span<const std::byte> b) override {
      const std::lock_guard lock(hub_.mutex_);
      for (Member* m : hub_.members_) {
        if (m == this || m->channels_.count(std::string(channel)) == 0) continue;
        m->inbox_.emplace_back(channel, std::vector<std::byte>(b.begin(), b.end()));
        const std::uint64_t one = 1;
        if (::write(m->fd_, &one, sizeof one) < 0) std::abort();
      }
    }

   private:
    friend class Hub;
    Hub& hub_;
    int fd_;
    std::set<std::string> channels_;
    std::deque<std::pair<std::string, std::vector<std::byte>>> inbox_;
  };

 private:
  std::mutex mutex_;
  std::set<Member*> members_;
};

/// A folder that is gone at the end.
class RunDir {
 public:
  RunDir() {
    char name[] = "/tmp/firn-test-XXXXXX";
    if (!::mkdtemp(name)) throw std::runtime_error("mkdtemp");
    path = name;
    std::filesystem::create_directories(path / "nodes");
    std::filesystem::create_directories(path / "io");
  }
  ~RunDir() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};

}  // namespace firn::test
