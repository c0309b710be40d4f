#include "print/operator/operator_desk.h"

#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <tuple>
#include <utility>

#include "files/usage_error.h"
#include "lcmtypes/utf8.h"
#include "runtime/socket_address.h"

namespace firn {
namespace {

constexpr int kBacklog = 128;  // who connects at one moment and waits to be accepted
constexpr int kAcceptedPerTurn = 256;
constexpr std::size_t kLongestLine_bytes = 4096;
constexpr std::size_t kLongestOwnLine_bytes = 262'144;  // a message of 4,096 values as JSON
constexpr std::size_t kLongestName_bytes = 40;
constexpr std::string_view kFrom = "from ", kRun = "run ", kOwn = "own ";
constexpr std::string_view kWaits = "note the print waits", kGoesOn = "note the print goes on";  // scheduler

// A client that reads nothing must not hold up the print.
bool say(int fd, const std::string& line) {
  const std::string text = line + "\n";
  return ::send(fd, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) == ssize_t(text.size());
}

std::string effect_of(const OperatorOrder& order) {
  switch (order.verb) {
    case OperatorVerb::kPause:
      return "pause: the print waits before its next pass, path or scan";
    case OperatorVerb::kContinue:
      return "continue: the print goes on";
    case OperatorVerb::kFinishLayer:
      return "finish-layer: this layer is finished and measured, then the print ends";
    case OperatorVerb::kAcceptDoubt:
      return "accept-doubt: a print that waits for this word goes on";
    case OperatorVerb::kSet:
      return to_text(order) + ": holds from the next decision on";
    case OperatorVerb::kStop:
      break;
  }
  return "stop: the lab is stopped";
}

// The resume was the operator's word: only changes and acceptances of before it still count.
bool holds_after_resume(OperatorVerb verb) {
  return verb == OperatorVerb::kSet || verb == OperatorVerb::kAcceptDoubt;
}

}  // namespace

std::filesystem::path operator_socket(const std::filesystem::path& run) { return run / "operator"; }

OperatorDesk::OperatorDesk(const std::filesystem::path& run, std::int64_t run_id,
                           const Experiment& experiment, Note note)
    : path_(operator_socket(run)), run_id_(run_id), changes_(experiment), note_(std::move(note)) {
  if (keys_.fd() >= 0) note_(std::string(KeyReader::kHelp));
  const SocketAddress address(path_);
  ::unlink(path_.c_str());
  listening_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  // Nobody can connect before listen().
  if (listening_ >= 0 && ::bind(listening_, address.get(), sizeof(sockaddr_un)) == 0 &&
      ::chmod(path_.c_str(), S_IRUSR | S_IWUSR) == 0 && ::listen(listening_, kBacklog) == 0)
    return;
  note_(path_.string() + ": firn ctl and firn attach cannot reach this print: " + std::strerror(errno));
  if (listening_ >= 0) ::close(listening_);
  listening_ = -1;
}

OperatorDesk::~OperatorDesk() {
  for (const Client& c : clients_)
    if (c.fd >= 0) ::close(c.fd);
  if (listening_ < 0) return;
  ::close(listening_);
  ::unlink(path_.c_str());
}

void OperatorDesk::remember(const OperatorOrder& order) {
  if (order.id != 0) taken_.try_emplace(order.id, Taken{to_text(order), true});
  if (order.verb == OperatorVerb::kSet) changes_.set(order.key, order.value);
}

void OperatorDesk::add_to(std::vector<pollfd>& fds) const {
  if (listening_ >= 0) fds.push_back({listening_, POLLIN, 0});
  if (keys_.fd() >= 0) fds.push_back({keys_.fd(), POLLIN, 0});
  for (const Client& c : clients_) fds.push_back({c.fd, POLLIN, 0});
}

void OperatorDesk::wait(int milliseconds) const {
  std::vector<pollfd> fds;
  add_to(fds);
  ::poll(fds.data(), nfds_t(fds.size()), milliseconds);
}

void OperatorDesk::service(const Obey& obey) {
  accept_clients(obey);
  take_keys(obey);
  for (Client& c : clients_) read(c, obey);
  std::erase_if(clients_, [](const Client& c) { return c.fd < 0; });
}

void OperatorDesk::accept_clients(const Obey& obey) {
  for (int n = 0; listening_ >= 0 && n < kAcceptedPerTurn; ++n) {
    const int fd = ::accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) return;
    if (clients_.size() >= kPlaces) make_room(obey);
    Client& c = clients_.emplace_back();
    c.fd = fd;
    c.heard = ++heard_;
    read(c, obey);  // an order that came with the connection needs no place to wait in
    std::erase_if(clients_, [](const Client& gone) { return gone.fd < 0; });
  }
}

void OperatorDesk::make_room(const Obey& obey) {
  const auto longest_silent = std::ranges::min_element(
      clients_, {}, [](const Client& c) { return std::tuple(c.awaits_stop, c.attached, c.heard); });
  read(*longest_silent, obey);
  if (longest_silent->fd >= 0) ::close(longest_silent->fd);
  clients_.erase(longest_silent);
}

void OperatorDesk::read(Client& c, const Obey& obey) {
  if (c.fd < 0) return;
  char chunk[kLongestLine_bytes];
  const ssize_t got = ::recv(c.fd, chunk, sizeof chunk, 0);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  const auto close = [&] {
    ::close(c.fd);
    c.fd = -1;
  };
  if (got <= 0) return close();
  c.buffer.append(chunk, std::size_t(got));
  for (std::size_t end; c.fd >= 0 && (end = c.buffer.find('\n')) != std::string::npos;) {
    const std::string line = c.buffer.substr(0, end);
    c.buffer.erase(0, end + 1);
    take(c, line, obey);
  }
  const std::size_t longest = c.buffer.starts_with(kOwn) ? kLongestOwnLine_bytes : kLongestLine_bytes;
  if (c.buffer.size() > longest) {
    say(c.fd, "refused a line of more than " + std::to_string(longest) + " bytes");
    close();
  }
}

void OperatorDesk::take(Client& c, const std::string& line, const Obey& obey) {
  c.heard = ++heard_;
  std::string answer;
  if (line == "attach") {
    c.attached = true;
    if (!waits_.empty()) answer = "note " + waits_;
  } else if (line == "state") {
    answer = !waits_.empty() ? "state paused: " + waits_ : pausing_ ? "state pausing" : "state running";
  } else
    try {
      answer = obey_line(c, line, obey);
    } catch (const UsageError& e) {
      answer = std::string("refused ") + e.what();
    }
  if (!answer.empty() && !say(c.fd, answer)) {
    ::close(c.fd);
    c.fd = -1;
  }
}

// Empty: the answer comes later, or none is wanted.
std::string OperatorDesk::obey_line(Client& c, const std::string& line, const Obey& obey) {
  if (line != valid_utf8(line) ||
      std::ranges::any_of(line, [](char b) { return (b >= 0 && b < 0x20) || b == 0x7f; }))
    throw UsageError("a line must be printable UTF-8, which a message can carry");
  if (line.starts_with(kFrom)) {
    c.name = valid_utf8(line.substr(kFrom.size(), kLongestName_bytes));
    return {};
  }
  if (line.starts_with(kRun)) {
    c.run_id = line.substr(kRun.size());
    return {};
  }
  if (line.starts_with(kOwn)) {
    require_this_run(c);
    if (!own_) throw UsageError("a print in one process takes nothing from other programs");
    return own_(line.substr(kOwn.size()));
  }
  std::istringstream in(line);
  std::int64_t id = 0;
  std::vector<std::string> words(1);
  if (!(in >> id >> words.front()) || id < 1 || id > std::int64_t(1) << 53)
    throw UsageError("ID VERB [KEY=VALUE] is wanted");
  require_this_run(c);
  std::string rest;
  if (std::getline(in >> std::ws, rest); !rest.empty()) words.push_back(rest);
  OperatorOrder order = parse_order(words);
  order.id = id;
  std::string answer = obey_order(order, c.name, obey);
  if (order.verb != OperatorVerb::kStop || !answer.starts_with("ok ") || stopped_) return answer;
  c.awaits_stop = true;
  return {};
}

void OperatorDesk::require_this_run(const Client& c) const {
  if (!c.run_id.empty() && c.run_id != std::to_string(run_id_))
    throw UsageError("this print is run " + std::to_string(run_id_) + "; the order is for run " + c.run_id);
}

// An order that was obeyed before is obeyed once: firn ctl may send it again without knowing.
std::string OperatorDesk::obey_order(const OperatorOrder& order, const std::string& from, const Obey& obey) {
  const bool sets = order.verb == OperatorVerb::kSet;
  const std::string problem = sets ? change_problem(changes_.experiment(), order.key, order.value) : "";
  if (!problem.empty()) return "refused " + problem;
  if (const auto [at, is_new] = taken_.try_emplace(order.id, Taken{to_text(order)}); !is_new) {
    const Taken& before = at->second;
    const std::string number = "refused order " + std::to_string(order.id) + " was '" + before.text + "' ";
    constexpr const char* kWayOut = ": without --id it gets a number of its own";
    if (before.text != to_text(order)) return number + "and is no '" + to_text(order) + "'" + kWayOut;
    if (before.earlier && !holds_after_resume(order.verb))
      return number + "before the print was resumed, which ended its effect" + kWayOut;
    return "ok " + effect_of(order) + " (was taken before)";
  }
  if (sets) changes_.set(order.key, order.value);
  if (order.verb == OperatorVerb::kPause) pausing_ = true;
  if (order.verb == OperatorVerb::kContinue) pausing_ = false;
  obey(order, from);
  return "ok " + effect_of(order);
}

void OperatorDesk::take_keys(const Obey& obey) {
  while (const auto key = keys_.next()) {
    const KeyPress pressed = keys_.press(*key);
    if (!pressed.order) {
      note_(pressed.hint);
      continue;
    }
    const std::string answer = obey_order(*pressed.order, "key", obey);
    note_(answer.substr(answer.find(' ') + 1));
  }
}

void OperatorDesk::on_safe_stop() {
  stopped_ = true;
  for (Client& c : clients_)
    if (std::exchange(c.awaits_stop, false)) say(c.fd, "ok " + effect_of({0, OperatorVerb::kStop, {}, {}}));
}

void OperatorDesk::tell(const std::string& line) {
  std::string one = line;
  std::ranges::replace(one, '\n', ' ');
  if (one.starts_with(kWaits)) waits_ = one.substr(std::string_view("note ").size());
  if (one.starts_with(kGoesOn)) waits_.clear();
  for (Client& c : clients_)  // service() removes them: it may be the one that tells
    if (c.attached && c.fd >= 0 && !say(c.fd, one)) {
      ::close(c.fd);
      c.fd = -1;
    }
}

void OperatorDesk::tell(const layer_metrics_t& metrics) { tell(layer_line(metrics)); }

std::string layer_line(const layer_metrics_t& m) {
  char text[200];
  std::snprintf(text, sizeof text, "layer %d %d %.9g %.9g %.9g %lld", int(m.layer), int(m.layers_expected),
                m.mean_height_mm, m.target_mean_mm, m.rms_mm, static_cast<long long>(m.header.utime_us));
  return text;
}

std::optional<layer_metrics_t> parse_layer_line(const std::string& line) {
  std::istringstream in(line);
  std::string word;
  layer_metrics_t m{};
  if (in >> word >> m.layer >> m.layers_expected >> m.mean_height_mm >> m.target_mean_mm >> m.rms_mm >>
          m.header.utime_us &&
      word == "layer")
    return m;
  return std::nullopt;
}

}  // namespace firn
