#include "plant/world/serve.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "plant/world/ice_lab.h"
#include "plant/world/kept_world.h"

namespace firn::plant {
namespace {

volatile sig_atomic_t stop_requested = 0;

std::int64_t monotonic_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_BOOTTIME, &t);
  return std::int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

std::runtime_error failure(const std::string& what) {
  return std::runtime_error("world: " + what + ": " + std::strerror(errno));
}

/// Holds a descriptor and the bytes that wait to be written to it.
struct Peer {
  int fd = -1;
  std::string out;
  void close() {
    if (fd >= 0) ::close(fd);
    fd = -1;
    out.clear();
  }
  /// Writes as many bytes as possible; false when the other side is gone.
  bool flush() {
    while (fd >= 0 && !out.empty()) {
      const ssize_t n = ::send(fd, out.data(), out.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n < 0 && errno == ENOTSOCK) return plain_flush();
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK;
      out.erase(0, std::size_t(n));
    }
    return true;
  }

 private:
  bool plain_flush() {  // a control pipe instead of a socket pair
    const ssize_t n = ::write(fd, out.data(), out.size());
    if (n > 0) out.erase(0, std::size_t(n));
    return n >= 0 || errno == EAGAIN || errno == EINTR;
  }
};

int listen_on(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string text = path.string();
  std::string name = text;
  int folder = -1;
  if (name.size() >=
      sizeof address.sun_path) {  // an address holds 107 bytes: by way of the open folder, then
    folder = ::open(path.parent_path().c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) throw failure("cannot open " + path.parent_path().string());
    name = "/proc/self/fd/" + std::to_string(folder) + "/" + path.filename().string();
  }
  std::memcpy(address.sun_path, name.data(), name.size());
  ::unlink(text.c_str());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) throw failure("socket");
  const bool bound =
      ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 && ::listen(fd, 4) == 0;
  const auto error = failure("cannot listen on " + text);
  if (folder >= 0) ::close(folder);
  if (bound) return fd;
  ::close(fd);
  throw error;
}

class Server {
 public:
  Server(const ServeOptions& o, const WorldConfig& config)
      : options_(o),
        world_(o.run, config),
        earliest_us_(world_.world().now_us()),
        ports_(world_.world().ports()) {
    std::filesystem::create_directories(o.io);
    for (std::size_t n = 0; n < ports_.size(); ++n)
      if (!o.elsewhere.contains(ports_[n])) listeners_[n] = listen_on(o.io / ports_[n]);
    control_.fd = o.control_fd;
    say("READY");
  }
  ~Server() {
    for (std::size_t n = 0; n < ports_.size(); ++n) {
      clients_[n].close();
      if (listeners_[n] < 0) continue;
      ::close(listeners_[n]);
      ::unlink((options_.io / ports_[n]).c_str());
    }
  }

  void run(const sigset_t& during_poll) {
    while (goes_on()) {
      wait(during_poll);
      if (!stopping_) take_control();
      for (std::size_t n = 0; n < ports_.size(); ++n) take_port(n);
      world_.advance(now_us(), [this](const World::Sent& s) { deliver(s); });
      world_.flush_record();
      for (std::size_t n = 0; n < ports_.size(); ++n)
        if (!clients_[n].flush()) drop(n);
      control_.flush();
      world_.save_if_due();
    }
    for (const auto port : ports_)
      world_.disconnect(port, now_us());  // the instruments' own watchdogs see the link go
    world_.close();
  }

 private:
  // A killed world may have been ahead of everything that the nodes had written down.
  std::int64_t now_us() const {
    const std::int64_t since_ns = std::max<std::int64_t>(0, monotonic_ns() - options_.epoch_ns);
    return std::max(earliest_us_,
                    std::int64_t(double(since_ns) * options_.time_scale * 1e-3) + options_.offset_us);
  }
  std::int64_t wall_ns(std::int64_t t_us) const {
    return options_.epoch_ns + std::int64_t(double(t_us - options_.offset_us) * 1e3 / options_.time_scale) +
           1;
  }

  // A launcher that dies closes its end of every control line: the drivers then make their instruments safe,
  // and the instruments must still be there to obey. Nature stays until the last driver has gone, for a
  // limited time.
  bool goes_on() {
    constexpr std::int64_t kLinger_ns = 2'000'000'000;
    if (!stopping_ && !stop_requested) return true;
    if (stop_since_ns_ == 0) stop_since_ns_ = monotonic_ns();
    stopping_ = true;
    return monotonic_ns() - stop_since_ns_ < kLinger_ns &&
           std::any_of(clients_.begin(), clients_.end(), [](const Peer& p) { return p.fd >= 0; });
  }

  // Bytes leave on time; inner events are computed a few milliseconds later, for their exact times.
  void wait(const sigset_t& during_poll) {
    constexpr std::int64_t kInnerDelay_ns = 5'000'000, kLongest_ns = 1'000'000'000, kStopping_ns = 20'000'000;
    const std::int64_t now = monotonic_ns();
    std::int64_t until = now + (stopping_ ? kStopping_ns : kLongest_ns);
    if (const std::int64_t t = world_.world().next_event_us(); t != INT64_MAX)
      until = std::min(until, wall_ns(t));
    if (const std::int64_t t = world_.world().next_inner_us(); t != INT64_MAX)
      until = std::min(until, std::max(wall_ns(t), now + kInnerDelay_ns));
    const std::int64_t left = std::max<std::int64_t>(0, until - now);
    const timespec timeout{left / 1'000'000'000, left % 1'000'000'000};
    std::vector<pollfd>& polls = polls_;
    for (std::size_t n = 0; n < ports_.size(); ++n)
      polls[n] = clients_[n].fd >= 0
                     ? pollfd{clients_[n].fd, short(clients_[n].out.empty() ? POLLIN : POLLIN | POLLOUT), 0}
                     : pollfd{listeners_[n], POLLIN, 0};
    polls[ports_.size()] = {stopping_ ? -1 : control_.fd, POLLIN, 0};  // -1 is passed over
    ::ppoll(polls.data(), polls.size(), &timeout, &during_poll);
  }

  void take_port(std::size_t n) {
    if (clients_[n].fd < 0) {
      if (listeners_[n] < 0) return;
      clients_[n].fd = ::accept4(listeners_[n], nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
      if (clients_[n].fd >= 0) world_.connect(ports_[n], now_us());
      return;
    }
    std::array<std::byte, 65536> bytes;
    for (;;) {
      const ssize_t got = ::recv(clients_[n].fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (got > 0) {
        world_.receive(ports_[n], std::span(bytes).first(std::size_t(got)), now_us());
        continue;
      }
      if (got < 0 && errno == EINTR) continue;
      if (got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK)) drop(n);
      return;
    }
  }

  void drop(std::size_t n) {
    if (clients_[n].fd < 0) return;
    clients_[n].close();
    world_.disconnect(ports_[n], now_us());
  }

  void deliver(const World::Sent& s) {
    const std::size_t n = std::size_t(std::find(ports_.begin(), ports_.end(), s.port) - ports_.begin());
    if (s.close) {
      clients_[n].flush();
      clients_[n].close();
    } else if (clients_[n].fd >= 0) {
      clients_[n].out.append(reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size());
    }
  }

  void take_control() {
    if (control_.fd < 0) return;
    std::array<char, 4096> bytes;
    for (;;) {
      const ssize_t got = ::read(control_.fd, bytes.data(), bytes.size());
      if (got > 0)
        heard_.append(bytes.data(), std::size_t(got));
      else if (got < 0 && errno == EINTR)
        continue;
      else if (got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK))
        stopping_ = true;
      if (got <= 0) break;
    }
    for (std::size_t end; (end = heard_.find('\n')) != std::string::npos; heard_.erase(0, end + 1))
      command(heard_.substr(0, end));
  }

  void command(const std::string& line) {
    std::istringstream words(line);
    std::string verb;
    words >> verb;
    if (verb == "STOP") stopping_ = true;
    if (verb == "TRUTH") {
      world_.advance(now_us(), [this](const World::Sent& s) { deliver(s); });
      say(truth_line(world_.tell_truth(now_us())));
    }
    if (verb == "WEIGH") weigh(words);
    if (verb != "SIMFAULT") return;
    try {
      SimFault fault;
      std::string kind;
      words >> fault.port >> kind;
      fault.kind = fault_kind(kind);
      if (std::int64_t value = 0; words >> value) fault.count = value;
      if (std::int64_t value = 0; words >> value) fault.delay_us = value;
      world_.inject(fault, now_us());
      say("OK");
    } catch (const std::invalid_argument& e) {
      say(std::string("ERROR ") + e.what());
    }
  }

  void weigh(std::istringstream& words) {
    int material = -1;
    std::uint32_t weighing = 0;
    const IceLab* lab = world_.world().ice();
    if (!(words >> material >> weighing) || material < 0 || material > 1 || !lab)
      return say("ERROR WEIGH material weighing: material 0 or 1, of an ice lab");
    world_.advance(now_us(), [this](const World::Sent& s) { deliver(s); });
    say("WEIGHED " + std::to_string(lab->weighed_mg(material, weighing)));
  }

  void say(const std::string& line) {
    if (control_.fd < 0) return;
    control_.out += line + "\n";
    control_.flush();
  }

  ServeOptions options_;
  KeptWorld world_;
  std::int64_t earliest_us_;
  std::span<const std::string_view> ports_;
  std::vector<int> listeners_ = std::vector<int>(ports_.size(), -1);
  std::vector<Peer> clients_ = std::vector<Peer>(ports_.size());
  std::vector<pollfd> polls_ = std::vector<pollfd>(ports_.size() + 1);
  Peer control_;
  std::string heard_;
  bool stopping_ = false;
  std::int64_t stop_since_ns_ = 0;
};

}  // namespace

void serve(const ServeOptions& options, const WorldConfig& config) {
  stop_requested = 0;
  ::signal(SIGINT, SIG_IGN);  // the launcher decides the meaning of Ctrl-C
  ::signal(SIGHUP, SIG_IGN);
  ::signal(SIGPIPE, SIG_IGN);
  struct sigaction action {};
  action.sa_handler = [](int) { stop_requested = 1; };
  ::sigaction(SIGTERM, &action, nullptr);
  sigset_t blocked, during_poll;
  ::sigemptyset(&blocked);
  ::sigaddset(&blocked, SIGTERM);  // arrives only inside ppoll, so that every one wakes it
  ::sigprocmask(SIG_BLOCK, &blocked, &during_poll);
  ::sigdelset(&during_poll, SIGTERM);
  if (options.control_fd >= 0 &&
      ::fcntl(options.control_fd, F_SETFL, ::fcntl(options.control_fd, F_GETFL) | O_NONBLOCK) != 0)
    throw failure("control descriptor " + std::to_string(options.control_fd));
  Server(options, config).run(during_poll);
}

}  // namespace firn::plant
