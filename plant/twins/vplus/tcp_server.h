// TcpServer simulates the TCP device of V+ with one client: FOPEN takes one string, READ returns the bytes
// that have come without regard for lines, a client that is gone keeps its place until FCMND 600 [AdeptNet
// guide; adept_experimental, which has run on a Cobra s600].
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "plant/record/archive.h"

namespace firn::plant::vplus {

/// Values of IOSTAT.
enum Status : int {
  kDone = 1,
  kClientCame = 100,
  kClientGone = 101,
  kNoDevice = -508,
  kNothingYet = -526,
  kClosedByClient = -562,
};

class TcpServer {
 public:
  static constexpr std::size_t kMostOfARead = 128;     ///< characters of a V+ string
  static constexpr std::size_t kMostUnread = 1 << 17;  ///< bytes: beyond these the connection is lost

  /// @param gone IOSTAT's number when the client has closed: kClientGone or kClosedByClient, by firmware
  explicit TcpServer(int gone = kClientGone) : gone_(gone) {}

  int attach(std::string_view device);
  int open(const std::vector<std::string>& texts);
  int command(int code);
  /// Takes the next event. @param text its characters, at most 128
  int read(std::string& text);
  int read_byte();  ///< GETC without waiting: the byte, or a negative status
  bool can_write() const { return open_ && taken_ && connected_; }

  void connected();
  void disconnected();
  /// One segment as the network delivers it. @returns false where the client must be disconnected
  bool arrived(std::string_view bytes);
  void io(Archive& a) { a.all(attached_, open_, taken_, connected_, unread_, events_); }

 private:
  struct Event {
    std::int32_t status = 0;  ///< 0: bytes
    std::string bytes;
    void io(Archive& a) { a.all(status, bytes); }
  };
  const Event* next() const;

  std::int32_t gone_;
  bool attached_ = false, open_ = false, taken_ = false, connected_ = false;
  std::uint64_t unread_ = 0;
  std::deque<Event> events_;
};

}  // namespace firn::plant::vplus
