#include "procs/bus/bus_key.h"

#include <openssl/crypto.h>
#include <sys/random.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace firn {
namespace {

constexpr std::string_view kVerb = "KEY ";
constexpr std::string_view kDigits = "0123456789abcdef";

}  // namespace

BusKey BusKey::random() {
  BusKey key;
  ssize_t got = 0;
  do got = ::getrandom(key.bytes.data(), key.bytes.size(), 0);
  while (got < 0 && errno == EINTR);
  if (got != ssize_t(key.bytes.size()))
    throw std::runtime_error(std::string("getrandom, for the key of the bus: ") + std::strerror(errno));
  return key;
}

std::string BusKey::line() const { return std::string(kVerb) + hex(); }

std::string BusKey::hex() const {
  std::string text;
  for (const std::byte b : bytes) {
    text += kDigits[std::size_t(b) >> 4];
    text += kDigits[std::size_t(b) & 15];
  }
  return text;
}

std::optional<BusKey> BusKey::from_line(std::string_view line) {
  BusKey key;
  if (line.size() != kVerb.size() + 2 * key.bytes.size() || !line.starts_with(kVerb)) return std::nullopt;
  line.remove_prefix(kVerb.size());
  for (std::size_t n = 0; n < line.size(); ++n) {
    const std::size_t digit = kDigits.find(line[n]);
    if (digit == std::string_view::npos) return std::nullopt;
    key.bytes[n / 2] = key.bytes[n / 2] << 4 | std::byte(digit);
  }
  return key;
}

std::string_view own_program_of(std::string_view channel) {
  if (!channel.starts_with(kOwnPrefix)) return {};
  channel.remove_prefix(kOwnPrefix.size());
  const std::size_t end = channel.find('/');
  return end == std::string_view::npos || end + 1 == channel.size() ? std::string_view()
                                                                    : channel.substr(0, end);
}

bool bus_is_keyed(std::string_view url) {
  std::size_t at = url.find('?');
  while (at != std::string_view::npos) {
    url.remove_prefix(at + 1);
    at = url.find('&');
    if (url.substr(0, at) == "key=none") return false;
  }
  return true;
}

std::optional<BusKey> take_bus_key(const ProcessArgs& args) {
  if (!bus_is_keyed(args.bus_url)) {
    std::fprintf(stderr, "%s: key=none: messages of any program on this host are taken\n",
                 info(args.options.node).name.data());
    return std::nullopt;
  }
  char line[sizeof "KEY " + 64];  // with its line break
  ssize_t got = -1;
  do got = ::recv(args.options.control_fd, line, sizeof line, MSG_WAITALL);
  while (got < 0 && errno == EINTR);
  const auto key = got == ssize_t(sizeof line) && line[got - 1] == '\n'
                       ? BusKey::from_line({line, std::size_t(got) - 1})
                       : std::nullopt;
  OPENSSL_cleanse(line, sizeof line);
  if (!key)
    throw std::runtime_error("no key for the bus " + args.bus_url +
                             " came by the control line; firn print hands it over, a bus without one has the "
                             "option key=none");
  return key;
}

}  // namespace firn
