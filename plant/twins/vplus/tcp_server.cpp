#include "plant/twins/vplus/tcp_server.h"

#include <algorithm>

namespace firn::plant::vplus {

int TcpServer::attach(std::string_view device) {
  attached_ = device == "TCP";
  return attached_ ? kDone : kNoDevice;
}

int TcpServer::open(const std::vector<std::string>& texts) {
  open_ = attached_ && texts.size() == 1 && texts[0].starts_with("/LOCAL_PORT ");
  return open_ ? kDone : kNoDevice;
}

int TcpServer::command(int code) {
  constexpr int kFreeClient = 600;
  if (!open_ || code != kFreeClient) return kNoDevice;
  taken_ = false;
  return kDone;
}

// A client that comes while the place is taken waits, and so do its bytes.
const TcpServer::Event* TcpServer::next() const {
  if (!open_ || events_.empty() || (events_.front().status == kClientCame && taken_)) return nullptr;
  return &events_.front();
}

int TcpServer::read(std::string& text) {
  text.clear();
  if (!open_) return kNoDevice;
  if (!next()) return kNothingYet;
  Event& event = events_.front();
  const int status = event.status == 0 ? int(kDone) : event.status;
  if (event.status == kClientCame) taken_ = true;
  if (event.status == 0) {
    text = event.bytes.substr(0, kMostOfARead);
    event.bytes.erase(0, text.size());
    unread_ -= text.size();
  }
  if (event.bytes.empty()) events_.pop_front();
  return status;
}

int TcpServer::read_byte() {
  if (!open_) return kNoDevice;
  const Event* event = next();
  if (!event) return kNothingYet;
  if (event->status != 0) {
    std::string none;
    const int status = read(none);
    return std::min(status, -status);
  }
  const int byte = static_cast<unsigned char>(event->bytes[0]);
  events_.front().bytes.erase(0, 1);
  --unread_;
  if (events_.front().bytes.empty()) events_.pop_front();
  return byte;
}

void TcpServer::connected() {
  connected_ = true;
  events_.push_back({kClientCame, {}});
}

void TcpServer::disconnected() {
  if (!connected_) return;
  connected_ = false;
  events_.push_back({gone_, {}});
}

bool TcpServer::arrived(std::string_view bytes) {
  if (!connected_ || bytes.empty()) return true;
  unread_ += bytes.size();
  events_.push_back({0, std::string(bytes)});
  return unread_ <= kMostUnread;
}

}  // namespace firn::plant::vplus
