// WebClient speaks HTTP and WebSocket to the page's server over a plain socket, independently of its library.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace firn::test {

class WebClient {
 public:
  /// @param address "http://127.0.0.1:8750/"
  /// @param token that requests show; empty: none
  explicit WebClient(const std::string& address, std::string token = "secret");
  ~WebClient();
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  struct Reply {
    int status = 0;
    std::string head, body;
  };
  /// @param lines further header lines, "Origin: http://x"; without a Host line this page's own is sent
  Reply request(const std::string& method, const std::string& target,
                const std::vector<std::string>& lines = {}, const std::string& body = "");
  Reply get(const std::string& target) { return request("GET", target); }

  /// Opens a WebSocket. @returns the status, 101 = open
  int open(const std::string& target, const std::vector<std::string>& lines = {});
  void send(const std::string& text) { send_frame(0x1, text); }
  /// Sends a frame of any kind: 1 text, 2 binary, 8 close, 9 ping.
  void send_frame(int opcode, const std::string& payload);
  void send_raw(const std::string& bytes);
  struct Frame {
    int opcode = 0;
    std::string payload;
  };
  /// Returns the next text or binary frame; nothing after `seconds`, or after the end.
  std::optional<Frame> next(double seconds);
  /// Returns the next text frame whose "type" is `type`; others are passed over.
  std::optional<std::string> next_of(const std::string& type, double seconds);
  /// Returns the next binary frame; others are passed over.
  std::optional<std::string> next_map(double seconds);
  bool closed() const { return closed_; }
  int fd() const { return fd_; }

 private:
  bool fill(double seconds);
  Reply read_reply();

  int fd_ = -1;
  std::string host_, token_, buffer_;
  bool closed_ = false;
};

}  // namespace firn::test
