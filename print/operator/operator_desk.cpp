#include "print/operator/operator_desk.h"

#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <utility>

#include "files/usage_error.h"
#include "runtime/socket_address.h"

namespace firn {
namespace {

constexpr std::size_t kMostClients = 16;
constexpr std::size_t kLongestLine_bytes = 4096;
constexpr std::size_t kLongestName_bytes = 40;
constexpr std::string_view kFrom = "from ";

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

}  // namespace

std::filesystem::path operator_socket(const std::filesystem::path& run) { return run / "operator"; }

OperatorDesk::OperatorDesk(const std::filesystem::path& run, const Experiment& experiment, Note note)
    : path_(operator_socket(run)), changes_(experiment), note_(std::move(note)) {
  if (keys_.fd() >= 0) note_(std::string(KeyReader::kHelp));
  const SocketAddress address(path_);
  ::unlink(path_.c_str());
  listening_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  // Nobody can connect before listen().
  if (listening_ >= 0 && ::bind(listening_, address.get(), sizeof(sockaddr_un)) == 0 &&
      ::chmod(path_.c_str(), S_IRUSR | S_IWUSR) == 0 && ::listen(listening_, int(kMostClients)) == 0)
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
  accept_clients();
  take_keys(obey);
  for (Client& c : clients_) read(c, obey);
  std::erase_if(clients_, [](const Client& c) { return c.fd < 0; });
}

void OperatorDesk::accept_clients() {
  while (listening_ >= 0 && clients_.size() < kMostClients) {
    const int fd = ::accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) return;
    clients_.emplace_back().fd = fd;
  }
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
  if (c.buffer.size() > kLongestLine_bytes) {
    say(c.fd, "refused a line of more than " + std::to_string(kLongestLine_bytes) + " bytes");
    close();
  }
}

void OperatorDesk::take(Client& c, const std::string& line, const Obey& obey) {
  std::string answer;
  if (line == "attach") {
    c.attached = true;
    return;
  }
  if (line.starts_with(kFrom)) {
    c.name = line.substr(kFrom.size(), kLongestName_bytes);
    return;
  }
  try {
    std::istringstream in(line);
    std::int64_t id = 0;
    std::vector<std::string> words(1);
    if (!(in >> id >> words.front()) || id < 1 || id > std::int64_t(1) << 53)
      throw UsageError("ID VERB [KEY=VALUE] is wanted");
    std::string rest;
    if (std::getline(in >> std::ws, rest); !rest.empty()) words.push_back(rest);
    OperatorOrder order = parse_order(words);
    order.id = id;
    answer = obey_order(order, c.name, obey);
    c.awaits_stop = c.awaits_stop || order.verb == OperatorVerb::kStop;
    if (order.verb == OperatorVerb::kStop && !stopped_) return;
  } catch (const UsageError& e) {
    answer = std::string("refused ") + e.what();
  }
  if (!say(c.fd, answer)) {
    ::close(c.fd);
    c.fd = -1;
  }
}

// An order that was obeyed before is obeyed once: firn ctl may send it again without knowing.
std::string OperatorDesk::obey_order(const OperatorOrder& order, const std::string& from, const Obey& obey) {
  const bool sets = order.verb == OperatorVerb::kSet;
  const std::string problem = sets ? change_problem(changes_.experiment(), order.key, order.value) : "";
  if (!problem.empty()) return "refused " + problem;
  if (!changes_.take(order.id)) return "ok " + effect_of(order) + " (was taken before)";
  if (sets) changes_.set(order.key, order.value);
  obey(order, from);
  return "ok " + effect_of(order);
}

void OperatorDesk::take_keys(const Obey& obey) {
  while (const auto key = keys_.next()) {
    const auto order = KeyReader::order_of(*key);
    if (!order) {
      note_(std::string(KeyReader::kHelp));
      continue;
    }
    const std::string answer = obey_order(*order, "key", obey);
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
