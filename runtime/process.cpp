#include "runtime/process.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/options/number.h"
#include "files/run_paths.h"
#include "firn/device_state_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/enums.h"
#include "firn/safe_stop_t.hpp"
#include "runtime/control_line.h"
#include "runtime/faults_file.h"
#include "runtime/heartbeat.h"
#include "runtime/port_rate.h"
#include "runtime/ports.h"
#include "runtime/precedence.h"
#include "runtime/process_args.h"
#include "runtime/python_port.h"
#include "runtime/transport.h"
#include "runtime/wal_file.h"

namespace firn {
namespace {

constexpr std::int64_t kSafeWithinUs = 1'000'000;  // a driver's time to become safe after a local stop
constexpr std::int64_t kLingerUs = 20'000;         // for datagrams that still wait when all is said
// Safety looks at the time so often, to notice that this computer stood still.
constexpr std::int64_t kSafetyLooksUs = 50'000;
// A wait that ends so much later than asked for: the computer slept, its virtual machine was moved or paused.
constexpr std::int64_t kStoodStillUs = 1'000'000;

struct Pending {
  EventKind kind;
  std::string_view channel;  // in the channel table
  std::uint32_t id = 0;
  LinkState link = LinkState::kClosed;
  std::vector<std::byte> bytes;
};

class Runner {
 public:
  Runner(const ProcessOptions& options, std::unique_ptr<Node> node, Bus& bus, ControlLine& control)
      : options_(options),
        run_(options.run_dir),
        name_(info(options.node).name),
        clock_(options.epoch_ns, options.offset_us, options.time_scale),
        bus_(bus),
        wal_(run_.wal_path(name_), options.incarnation > 0),
        host_(options.node, std::move(node), options.run_id, &wal_),
        transport_(
            {.self = options.node,
             .run_id = options.run_id,
             .incarnation = options.incarnation,
             .burst_bytes = TransportOptions::burst_into(bus.receive_buffer_bytes())},
            [this](const ChannelInfo& row, std::span<const std::byte> b) { received(row, b); },
            [this](std::string_view c, std::int64_t s, std::vector<std::byte>& to) {
              return find_sent(wal_.path(), c, s, to);
            }),
        lossy_(options.faults),
        faults_file_(run_.nodes_path() / (name_ + ".faults"), options.faults.any()),
        ports_(
            port_addresses(), [this] { return lease_refusal(); }, port_rates()),
        control_(control) {
    if (options_.record && !host_.ports().empty()) record_ports();
  }

  int run();

 private:
  std::vector<PortAddress> port_addresses() const {
    std::vector<PortAddress> addresses;
    for (const std::string& port : host_.ports()) {
      const auto real = options_.real_ports.find(port);
      PortAddress address = real != options_.real_ports.end() ? real->second
                            : port == python_port(name_)      ? parse_port_address("python:")
                                                              : unix_port(run_.port_path(port).string());
      if (address.kind == PortAddress::Kind::kPython) address.driver_files = driver_files();
      addresses.push_back(std::move(address));
    }
    return addresses;
  }
  /// The recorded modules of the node's driver class, not those that lie beside the lab file today.
  std::vector<std::pair<std::string, std::string>> driver_files() const {
    std::vector<std::pair<std::string, std::string>> files;
    const std::string role = driver_role(name_);
    for (const auto& [of, sha256] : options_.head.blobs)
      if (of.starts_with(role)) files.emplace_back(of.substr(role.size()), run_.input_path(sha256).string());
    return files;
  }
  std::vector<PortRate> port_rates() const {
    std::vector<PortRate> rates;
    const std::vector<PortAddress> addresses = port_addresses();
    for (const std::string& port : host_.ports())
      rates.push_back(port_rate(port, addresses[rates.size()]).at(options_.time_scale));
    return rates;
  }
  void record_ports();
  void record_order(const Event& event);
  void write_heads();
  void come_back();
  void received(const ChannelInfo& row, std::span<const std::byte> bytes);
  void step(const Event& event);
  void carry_out(const Outbox& outbox);
  void step_once();
  void handle(std::deque<Pending>& queue, std::deque<Pending>::iterator next);
  void listen_to_launcher();
  void follow_launcher(std::string_view numbers);
  void local_stop(const std::string& cause);
  void stood_still(std::int64_t us);
  void send_waiting();
  void wait();
  void receive_from_bus(std::int64_t wall_us);
  void read_launcher();
  std::string lease_refusal();
  void tell_refused();
  void notices();
  bool over() const;

  ProcessOptions options_;
  RunPaths run_;
  std::string name_, port_trouble_;
  RunClock clock_;
  Bus& bus_;
  WalFile wal_;
  NodeHost host_;
  Transport transport_;
  Lossy lossy_;
  FaultsFile faults_file_;
  Ports ports_;
  std::ofstream cassette_;
  std::int64_t recorded_epoch_ = -1;
  ControlLine& control_;
  std::unique_ptr<Heartbeat> heartbeat_;
  std::deque<Pending> messages_;
  std::deque<Pending> port_events_;  // of one turn: the rest waits in the kernel
  std::deque<std::string> lines_;    // of the launcher, not handled yet
  std::int32_t last_head_ = -1;      // incarnation of the last head in the write-ahead file
  bool started_ = false, stopping_ = false, safe_ = false, told_finish_ = false;
  std::int64_t stop_by_us_ = INT64_MAX;
};

// An incarnation goes on where the one before ended: node time does.
void Runner::record_ports() {
  const std::filesystem::path file = run_.path() / "cassettes" / (name_ + ".cassette");
  std::filesystem::create_directories(file.parent_path());
  const bool begins = !std::filesystem::exists(file);
  cassette_.open(file, std::ios::app | std::ios::binary);
  if (!cassette_) throw std::runtime_error(file.string() + ": " + std::strerror(errno));
  if (begins) {
    const PortAddress address = port_addresses().front();
    const bool real = options_.real_ports.contains(name_) && address.real();
    cassette_ << cassette_head(name_, (real ? "REAL " : "SIMULATED ") + to_text(address),
                               read_text_file(run_.experiment_path()));
  } else {
    cassette_ << "# incarnation " << options_.incarnation << "\n";
  }
  // Of a class in Python that speaks through the instrument's port, that port's bytes.
  ports_.record([this](PortId port, Cassette::Kind kind, std::span<const std::byte> bytes) {
    if (port == PortId{0})
      cassette_ << cassette_line(kind, double(clock_.now().us) * 1e-3, bytes) << std::flush;
  });
}

int Runner::run() {
  for (const std::string_view channel : host_.channels()) transport_.subscribe(channel);
  if (options_.incarnation > 0) {
    try {
      come_back();
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s: %s\n", name_.c_str(), e.what());
      control_.say(std::string("ERROR ") + e.what());
      return kExitResume;
    }
  }
  write_heads();
  host_.set_stopwatch(monotonic_ns);
  for (const std::string& channel : transport_.wire_channels()) bus_.subscribe(channel);
  heartbeat_ =
      std::make_unique<Heartbeat>(options_.node, options_.run_id, options_.incarnation, clock_, bus_);
  heartbeat_->update(host_.steps(), transport_.stats(), transport_.last_sent());
  control_.say("READY");

  while (!over()) {
    heartbeat_->set_busy(true);  // until it waits again: a stuck disk or port is seen like a stuck handler
    listen_to_launcher();
    step_once();
    send_waiting();
    wait();
    notices();
  }
  const std::int64_t until = monotonic_us() + kLingerUs;
  while (transport_.backlog_bytes() > 0 && monotonic_us() < until) send_waiting();
  faults_file_.write(lossy_.counts());
  return 0;
}

// An incarnation that ended before this process had begun has its head too: CONFIG_ is numbered by them.
void Runner::write_heads() {
  WalHead head = options_.head;
  std::vector<std::byte> bytes;
  for (head.incarnation = last_head_ + 1; head.incarnation <= options_.incarnation; ++head.incarnation) {
    bytes.clear();
    encode_head(head, bytes);
    wal_.append(WalKind::kHead, bytes);
    transport_.send(channels::config(options_.node).name, config_message(head), monotonic_us());
  }
}

void Runner::come_back() {
  std::vector<std::pair<std::string, std::vector<std::byte>>> unsent;
  restore(host_, options_.run_id, wal_,
          {[this](const WalHead& head) {
             last_head_ = head.incarnation;
             transport_.restore_sent(channels::config(options_.node).name, config_message(head));
           },
           [this](std::string_view c, std::span<const std::byte> b) { transport_.restore_received(c, b); },
           [this](std::string_view c, std::span<const std::byte> b) { transport_.restore_sent(c, b); },
           [&](std::string_view c, std::span<const std::byte> b) {
             unsent.emplace_back(c, std::vector<std::byte>(b.begin(), b.end()));
           }});
  for (const auto& [channel, bytes] : unsent) transport_.send(channel, bytes, monotonic_us());
}

void Runner::received(const ChannelInfo& row, std::span<const std::byte> bytes) {
  if (row.queue == 1)  // only the newest counts
    std::erase_if(messages_, [&](const Pending& p) { return p.channel == row.name; });
  messages_.push_back({EventKind::kMessage, row.name, 0, LinkState::kClosed, {bytes.begin(), bytes.end()}});
}

// Every message to the driver, and of the lease the first of each epoch: it is told of every 50 ms.
void Runner::record_order(const Event& event) {
  if (event.kind == EventKind::kLocalStop)
    cassette_ << cassette_order("stop", double(event.now.us) * 1e-3, {}, "");
  if (event.kind != EventKind::kMessage) return;
  if (enable_t lease; event.channel == channels::kEnable.name &&
                      lease.decode(event.bytes.data(), 0, int(event.bytes.size())) > 0) {
    if (lease.enable_epoch == recorded_epoch_) return;
    recorded_epoch_ = lease.enable_epoch;
  }
  cassette_ << cassette_order(event.channel, double(event.now.us) * 1e-3, event.bytes, "");
}

void Runner::step(const Event& event) {
  if (cassette_.is_open()) record_order(event);
  try {
    const Outbox& outbox = host_.step(event);
    Heartbeat::Step done{host_.steps(), event.kind, event.channel, int(outbox.size()), 0};
    for (std::size_t n = 0; n < outbox.size(); ++n)
      done.output_bytes += std::int64_t(outbox.at(n).bytes.size());
    heartbeat_->note(done);
    const bool stops = event.kind == EventKind::kLocalStop ||
                       (event.kind == EventKind::kMessage && event.channel == channels::kSafeStop.name);
    if (stops)
      for (std::size_t n = 0; n < host_.ports().size(); ++n) ports_.drop_waiting(PortId(n));
    carry_out(outbox);
    tell_refused();
  } catch (const std::exception& e) {
    throw std::runtime_error("step " + std::to_string(host_.steps()) + " (" + describe(event) +
                             "): " + e.what());
  }
}

void Runner::handle(std::deque<Pending>& queue, std::deque<Pending>::iterator next) {
  if (next == queue.end()) return;
  const Pending p = std::move(*next);
  queue.erase(next);
  Event e;
  e.now = clock_.now();
  e.kind = p.kind;
  e.channel = p.channel;
  e.id = p.id;
  e.link = p.link;
  e.bytes = p.bytes;
  step(e);
}

// A turn handles a timer, which a lease that is over is, one message and one event of a port. So however many
// bytes an instrument sends, a stop waits behind those of one turn at most; and it goes before other
// messages.
void Runner::step_once() {
  if (!started_) return;
  Event e;
  e.now = clock_.now();
  if (const auto timer = host_.next_timer(); timer && timer->at <= e.now) {
    e.kind = EventKind::kWake;
    e.id = std::uint32_t(timer->timer);
    e.due = timer->at;
    step(e);
  }
  const auto stop = std::ranges::find(messages_, channels::kSafeStop.name, &Pending::channel);
  handle(messages_, stop != messages_.end() ? stop : messages_.begin());
  handle(port_events_, port_events_.begin());
}

void Runner::carry_out(const Outbox& outbox) {
  const std::int64_t wall = monotonic_us();
  for (std::size_t n = 0; n < outbox.size(); ++n) {
    const Output o = outbox.at(n);
    switch (o.kind) {
      case OutputKind::kSend: {
        transport_.send(o.channel, o.bytes, wall);
        if (!o.channel.starts_with("STATE_")) break;
        device_state_t state{};
        if (state.decode(o.bytes.data(), 0, int(o.bytes.size())) > 0)
          safe_ = state.state == std::int8_t(DeviceState::kSafe) ||
                  state.state == std::int8_t(DeviceState::kDisconnected);
        break;
      }
      case OutputKind::kWrite:
        ports_.write(PortId(o.id), o.bytes, host_.writes_need_lease());
        break;
      case OutputKind::kReopen:
        ports_.reopen(PortId(o.id), wall);
        break;
      case OutputKind::kFinish:
        if (!std::exchange(told_finish_, true))
          control_.say("FINISH " + std::to_string(*host_.finished()) + " " + host_.finish_reason());
        break;
      case OutputKind::kArm:
      case OutputKind::kCancel:
        break;  // the host keeps the timers
    }
  }
  heartbeat_->update(host_.steps(), transport_.stats(), transport_.last_sent());
}

// The handler's time is over when bytes go out: the step was written to the disk meanwhile. So the clock, and
// stops that wait unhandled in the socket or on the line of the launcher, count once more.
std::string Runner::lease_refusal() {
  read_launcher();
  if (control_.closed() || std::ranges::any_of(lines_, [](const auto& l) { return l.starts_with("STOP"); }))
    return "the launcher says stop, or is gone";
  receive_from_bus(monotonic_us());
  std::int64_t stop_epoch = 0;
  for (const Pending& p : messages_) {
    safe_stop_t stop{};
    if (p.channel == channels::kSafeStop.name && stop.decode(p.bytes.data(), 0, int(p.bytes.size())) > 0)
      stop_epoch = std::max(stop_epoch, stop.enable_epoch);
  }
  return host_.lease_refusal(clock_.now(), stop_epoch);
}

void Runner::tell_refused() {
  std::vector<std::pair<std::uint32_t, std::string>> refused;
  ports_.take_refused(
      [&](PortId port, const std::string& cause) { refused.emplace_back(std::uint32_t(port), cause); });
  for (const auto& [port, cause] : refused) {
    Event e;
    e.kind = EventKind::kRefused;
    e.now = clock_.now();
    e.id = port;
    e.bytes = std::as_bytes(std::span(cause));
    step(e);
  }
}

void Runner::read_launcher() {
  while (auto line = control_.next()) lines_.push_back(std::move(*line));
}

void Runner::listen_to_launcher() {
  read_launcher();
  while (!lines_.empty()) {
    const std::string line = std::move(lines_.front());
    lines_.pop_front();
    if (line == "START" && !started_) {
      started_ = true;
      heartbeat_->set_state(Heartbeat::kRunning);
      Event e;
      e.kind = EventKind::kStart;
      e.now = clock_.now();
      e.incarnation = options_.incarnation;
      step(e);
      ports_.open_all(monotonic_us());
    } else if (line.starts_with("CLOCK ")) {  // on another host than the launcher's
      follow_launcher(std::string_view(line).substr(6));
    } else if (line.starts_with("STOP")) {
      local_stop(line.size() > 5 ? line.substr(5) : "the launcher said stop");
    }
  }
  if (control_.closed()) local_stop("the launcher is gone");
}

// "<ns of CLOCK_BOOTTIME> <node time at the launcher then, us>"
void Runner::follow_launcher(std::string_view numbers) {
  const std::size_t blank = numbers.find(' ');
  const auto mono_ns = whole_number<std::int64_t>(numbers.substr(0, blank));
  const auto node_us =
      blank == numbers.npos ? std::nullopt : whole_number<std::int64_t>(numbers.substr(blank + 1));
  if (mono_ns && node_us) clock_.follow({*mono_ns, Time{*node_us}}, monotonic_ns());
}

void Runner::local_stop(const std::string& cause) {
  if (stopping_) return;
  stopping_ = true;
  heartbeat_->set_state(Heartbeat::kStopping);
  stop_by_us_ = monotonic_us();
  if (!started_) return;
  safe_ = false;
  Event e;
  e.kind = EventKind::kLocalStop;
  e.now = clock_.now();
  e.bytes = std::as_bytes(std::span(cause));
  step(e);
  if (info(options_.node).driver) stop_by_us_ += kSafeWithinUs;
}

// Nobody knows the lab's acts meanwhile. Each driver's lease has ended; safety stops the print by this
// name, before it hears of the leases.
void Runner::stood_still(std::int64_t us) {
  char cause[80];
  std::snprintf(cause, sizeof cause, "this computer stood still for %.1f s", double(us) * 1e-6);
  std::fprintf(stderr, "%s: %s\n", name_.c_str(), cause);
  if (options_.node != NodeId::kSafety || !started_ || stopping_) return;
  Event e;
  e.kind = EventKind::kLocalStop;
  e.now = clock_.now();
  e.bytes = std::as_bytes(std::span(cause, std::strlen(cause)));
  step(e);
}

bool Runner::over() const { return stopping_ && (safe_ || monotonic_us() >= stop_by_us_); }

void Runner::send_waiting() {
  Transport::Datagram d;
  while (transport_.next_datagram(monotonic_us(), d)) bus_.publish(d.channel, d.bytes);
}

void Runner::wait() {
  const std::int64_t wall = monotonic_us();
  std::int64_t until = wall + (options_.node == NodeId::kSafety ? kSafetyLooksUs : kLongestPollUs);
  if (started_ && !(messages_.empty() && port_events_.empty())) until = wall;
  if (const auto timer = host_.next_timer(); started_ && timer)
    until = std::min(until, clock_.wall_us(timer->at));
  until = std::min({until, transport_.due_us(wall), lossy_.due_us(), ports_.due_us(), stop_by_us_});
  std::vector<pollfd> fds;
  fds.push_back({bus_.fd(), POLLIN, 0});
  if (control_.fd() >= 0 && !control_.closed()) fds.push_back({control_.fd(), POLLIN, 0});
  ports_.add_to(fds);
  const timespec timeout = poll_timeout(until - wall);
  heartbeat_->set_busy(false);
  ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
  heartbeat_->set_busy(true);

  const std::int64_t now = monotonic_us();
  if (const std::int64_t late = now - std::max(until, wall); late >= kStoodStillUs) stood_still(late);
  receive_from_bus(now);
  transport_.tick(now);
  ports_.service(
      now,
      [&](PortId id, LinkState link) {
        port_events_.push_back({EventKind::kLink, {}, std::uint32_t(id), link, {}});
      },
      [&](PortId id, std::span<const std::byte> b) {
        port_events_.push_back(
            {EventKind::kIo, {}, std::uint32_t(id), LinkState::kOpen, {b.begin(), b.end()}});
      });
  tell_refused();
}

void Runner::receive_from_bus(std::int64_t wall_us) {
  const Lossy::Sink into = [&](std::string_view c, std::span<const std::byte> b) {
    transport_.receive(c, b, wall_us);
  };
  if (options_.faults.any()) {
    bus_.receive(
        [&](std::string_view c, std::span<const std::byte> b) { lossy_.receive(c, b, wall_us, into); });
    lossy_.release(wall_us, into);
    faults_file_.write_sometimes(lossy_.counts(), wall_us);
  } else {
    bus_.receive(into);
  }
}

void Runner::notices() {
  if (const std::string trouble = ports_.trouble(); trouble != port_trouble_)
    control_.say("PORT " + (port_trouble_ = trouble));
  for (const std::string& text : ports_.take_notices())
    std::fprintf(stderr, "%s: %s\n", name_.c_str(), text.c_str());
  for (const std::string& text : transport_.take_notices())
    std::fprintf(stderr, "%s: %s\n", name_.c_str(), text.c_str());
}

}  // namespace

int run_process(const ProcessOptions& options, std::unique_ptr<Node> node, Bus& bus) {
  const std::string name(info(options.node).name);
  ControlLine control(options.control_fd);
  std::optional<Precedence> precedence;  // the end of a lease and a stop wait for no other work
  if (info(options.node).driver) precedence.emplace();
  try {
    return Runner(options, std::move(node), bus, control).run();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), e.what());
    control.say(std::string("FAULT ") + e.what());
    return kExitHandler;
  }
}

}  // namespace firn
