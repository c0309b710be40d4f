#include "tests/page/web_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace firn::test {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

WebClient::WebClient(const std::string& address, std::string token) : token_(std::move(token)) {
  const std::size_t begin = address.find("//") + 2;
  host_ = address.substr(begin, address.find('/', begin) - begin);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(std::uint16_t(std::stoi(host_.substr(host_.rfind(':') + 1))));
  fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) closed_ = true;
}

WebClient::~WebClient() { ::close(fd_); }

void WebClient::send_raw(const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t sent = ::send(fd_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (sent <= 0) {
      closed_ = true;
      return;
    }
    at += std::size_t(sent);
  }
}

bool WebClient::fill(double seconds) {
  pollfd ready{fd_, POLLIN, 0};
  if (closed_ || ::poll(&ready, 1, std::max(0, int(seconds * 1e3))) <= 0) return false;
  char chunk[65536];
  const ssize_t got = ::recv(fd_, chunk, sizeof chunk, 0);
  if (got <= 0) {
    closed_ = true;
    return false;
  }
  buffer_.append(chunk, std::size_t(got));
  return true;
}

WebClient::Reply WebClient::read_reply() {
  Reply r;
  std::size_t end;
  while ((end = buffer_.find("\r\n\r\n")) == std::string::npos)
    if (!fill(10.0)) return r;
  r.head = buffer_.substr(0, end + 2);
  buffer_.erase(0, end + 4);
  r.status = std::stoi(r.head.substr(9, 3));
  const std::size_t at = r.head.find("Content-Length: ");
  const std::size_t length = at == std::string::npos ? 0 : std::stoul(r.head.substr(at + 16));
  while (buffer_.size() < length && fill(10.0)) {
  }
  r.body = buffer_.substr(0, length);
  buffer_.erase(0, length);
  return r;
}

WebClient::Reply WebClient::request(const std::string& method, const std::string& target,
                                    const std::vector<std::string>& lines, const std::string& body) {
  std::string text = method + " " + target + " HTTP/1.1\r\n";
  const bool host = std::ranges::any_of(lines, [](const std::string& l) { return l.starts_with("Host:"); });
  if (!host) text += "Host: " + host_ + "\r\n";
  if (!token_.empty()) text += "Authorization: Bearer " + token_ + "\r\n";
  for (const std::string& line : lines) text += line + "\r\n";
  if (!body.empty()) text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  send_raw(text + "\r\n" + body);
  return read_reply();
}

int WebClient::open(const std::string& target, const std::vector<std::string>& lines) {
  std::vector<std::string> all{"Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13",
                               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="};
  all.insert(all.end(), lines.begin(), lines.end());
  return request("GET", target, all).status;
}

void WebClient::send_frame(int opcode, const std::string& payload) {
  std::string frame(1, char(0x80 | opcode));
  const std::size_t n = payload.size();
  if (n < 126) {
    frame += char(0x80 | n);
  } else {
    frame += char(0x80 | 126);
    frame += char(n >> 8 & 0xff);
    frame += char(n & 0xff);
  }
  const char mask[4] = {0x12, 0x34, 0x56, 0x78};
  frame.append(mask, 4);
  for (std::size_t k = 0; k < n; ++k) frame += char(payload[k] ^ mask[k % 4]);
  send_raw(frame);
}

std::optional<WebClient::Frame> WebClient::next(double seconds) {
  const double until = now_s() + seconds;
  for (;;) {
    std::size_t head = 2;
    if (buffer_.size() >= head) {
      const auto byte = [&](std::size_t k) { return std::uint64_t(static_cast<unsigned char>(buffer_[k])); };
      std::uint64_t length = byte(1) & 0x7f;
      const std::size_t more = length == 126 ? 2 : length == 127 ? 8 : 0;
      if (buffer_.size() >= head + more) {
        if (more > 0) length = 0;
        for (std::size_t k = 0; k < more; ++k) length = length << 8 | byte(head + k);
        head += more;
        if (buffer_.size() >= head + length) {
          Frame f{int(byte(0) & 0x0f), buffer_.substr(head, length)};
          buffer_.erase(0, head + length);
          if (f.opcode == 9) send_frame(10, f.payload);
          if (f.opcode == 8) closed_ = true;
          if (f.opcode == 1 || f.opcode == 2) return f;
          continue;
        }
      }
    }
    if (!fill(until - now_s()) && (closed_ || now_s() >= until)) return std::nullopt;
  }
}

std::optional<std::string> WebClient::next_of(const std::string& type, double seconds) {
  const double until = now_s() + seconds;
  while (const auto f = next(std::max(0.0, until - now_s())))
    if (f->opcode == 1 && f->payload.starts_with("{\"type\":\"" + type + "\"")) return f->payload;
  return std::nullopt;
}

std::optional<std::string> WebClient::next_map(double seconds) {
  const double until = now_s() + seconds;
  while (const auto f = next(std::max(0.0, until - now_s())))
    if (f->opcode == 2) return f->payload;
  return std::nullopt;
}

}  // namespace firn::test
