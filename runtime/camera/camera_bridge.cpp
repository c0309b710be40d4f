#include "runtime/camera/camera_bridge.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/options/number.h"
#include "drivers/camera/picture_line.h"
#include "runtime/camera/folder_source.h"
#include "runtime/camera/jpeg_frame.h"
#include "runtime/camera/v4l2_source.h"

namespace firn::camera {
namespace {

constexpr std::size_t kLongestLine = 200;
constexpr int kLook_ms = 50;

std::string_view next_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const std::string_view word = text.substr(0, text.find(' '));
  text.remove_prefix(word.size());
  return word;
}

template <class T>
bool read(std::string_view& text, T& value) {
  const std::optional<T> number = whole_number<T>(next_word(text));
  value = number.value_or(T{});
  return number.has_value();
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return text.substr(0, kLongestLine - 20);
}

}  // namespace

std::string PictureServer::answer(std::string_view line, const std::function<bool()>& ended) {
  std::string_view rest = line;
  const std::string_view verb = next_word(rest);
  if (verb == "ID") return "OK ID " + one_line(source_.name()) + "\n";
  if (verb == "SET") {
    ShotSettings s;
    if (!read(rest, s.exposure_us) || !read(rest, s.gain_db) || !read(rest, s.delay_us))
      return "NO SET takes exposure [us], gain [dB] and delay [us]\n";
    const std::string why = source_.set_up(s);
    return why.empty() ? "OK SET\n" : "NO SET " + one_line(why) + "\n";
  }
  std::int32_t number = 0;
  if (verb != "SNAP" || !read(rest, number) || number < 0)
    return "NO " + one_line(std::string(verb.substr(0, 20))) + " unknown\n";
  try {
    GreyShot s = source_.take(ended);
    return drivers::picture_line::encode(number, {s.width, s.height, s.white, s.age_us, std::move(s.pixels)});
  } catch (const SourceGone&) {
    throw;
  } catch (const std::runtime_error& problem) {
    return "NO SNAP " + one_line(problem.what()) + "\n";
  }
}

CameraBridge::CameraBridge(std::unique_ptr<PictureSource> source) : source_(std::move(source)) {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, pair) != 0)
    throw std::runtime_error(std::strerror(errno));
  own_ = pair[0];
  other_ = pair[1];
  thread_ = std::thread([this] { serve(); });
}

CameraBridge::~CameraBridge() {
  ended_ = true;
  thread_.join();
  if (other_ >= 0) ::close(other_);
}

int CameraBridge::take_fd() { return std::exchange(other_, -1); }

void CameraBridge::serve() {
  PictureServer server(*source_);
  std::string line, reply;
  bool overlong = false;
  try {
    while (!ended_) {
      pollfd p{own_, short(reply.empty() ? POLLIN : POLLIN | POLLOUT), 0};
      if (::poll(&p, 1, kLook_ms) <= 0) continue;
      if (!reply.empty() && p.revents & POLLOUT) {
        const ssize_t sent = ::send(own_, reply.data(), reply.size(), MSG_NOSIGNAL);
        if (sent > 0) reply.erase(0, std::size_t(sent));
        if (sent < 0 && errno != EAGAIN && errno != EINTR) break;
      }
      if (!(p.revents & (POLLIN | POLLHUP | POLLERR))) continue;
      char bytes[512];
      const ssize_t got = ::recv(own_, bytes, sizeof bytes, 0);
      if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) break;
      for (ssize_t n = 0; n < got; ++n) {
        if (bytes[n] != '\n') {
          overlong = overlong || line.size() >= kLongestLine;
          if (!overlong) line.push_back(bytes[n]);
          continue;
        }
        reply += overlong ? std::string("NO LINE too long\n")
                          : server.answer(line, [this] { return ended_.load(); });
        line.clear();
        overlong = false;
      }
    }
  } catch (const std::exception&) {  // the source has gone: the port is lost
  }
  ::close(own_);
}

std::unique_ptr<PictureSource> open_picture_source(const PortAddress& a) {
  if (a.kind == PortAddress::Kind::kFolder) return std::make_unique<FolderSource>(a.place);
  std::string why;
  auto device = open_video_device(a.place, why);
  if (!device) throw std::runtime_error(why);
  return std::make_unique<V4l2Source>(
      std::move(device), V4l2Options{a.width_px, a.height_px, a.format, a.delay_us, &decode_jpeg_frame});
}

}  // namespace firn::camera
