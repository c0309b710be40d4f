#include "runs/read/describe.h"

#include <cstdio>

#include "lcmtypes/channels.h"
#include "lcmtypes/schema.h"
#include "runs/read/channel_index.h"

namespace firn::runs {
namespace {

constexpr std::size_t kBytesTold = 80;  // of instrument bytes

std::string port_name(std::uint32_t id, const std::vector<std::string>& ports) {
  return "port " + (id < ports.size() ? ports[id] : std::to_string(id));
}

std::string seconds(Time t) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6f s", t.s());
  return text;
}

}  // namespace

std::string place_of(const Event& e, const std::vector<std::string>& ports) {
  switch (e.kind) {
    case EventKind::kStart:
      return "start";
    case EventKind::kMessage:
      return std::string(e.channel);
    case EventKind::kWake:
      return "timer " + std::to_string(e.id);
    case EventKind::kIo:
    case EventKind::kLink:
    case EventKind::kRefused:
      return port_name(e.id, ports);
    case EventKind::kLocalStop:
      return "local stop";
  }
  return "";
}

std::string place_of(const Output& o, const std::vector<std::string>& ports) {
  switch (o.kind) {
    case OutputKind::kSend:
      return std::string(o.channel);
    case OutputKind::kArm:
    case OutputKind::kCancel:
      return "timer " + std::to_string(o.id);
    case OutputKind::kWrite:
    case OutputKind::kReopen:
      return port_name(o.id, ports);
    case OutputKind::kFinish:
      return "finish";
  }
  return "";
}

std::string in_words(const Output& o) {
  switch (o.kind) {
    case OutputKind::kSend: {
      const auto stamp = stamp_of(o.bytes);
      return "send " + std::string(o.channel) + (stamp ? " " + std::to_string(stamp->seq) : "");
    }
    case OutputKind::kArm:
      return "arm timer " + std::to_string(o.id) + " for " + seconds(o.at);
    case OutputKind::kCancel:
      return "cancel timer " + std::to_string(o.id);
    case OutputKind::kWrite:
      return "write '" + escaped(o.bytes, kBytesTold) + "' to port " + std::to_string(o.id);
    case OutputKind::kReopen:
      return "reopen port " + std::to_string(o.id);
    case OutputKind::kFinish:
      return "finish with status " + std::to_string(o.id);
  }
  return "";
}

std::string as_json(std::uint64_t step, const Event& e, const std::vector<std::string>& ports) {
  std::string s = "{\"step\":" + std::to_string(step) + ",\"now_us\":" + std::to_string(e.now.us) +
                  ",\"from\":" + json_string(place_of(e, ports));
  switch (e.kind) {
    case EventKind::kStart:
      s += ",\"incarnation\":" + std::to_string(e.incarnation);
      break;
    case EventKind::kMessage: {
      const ChannelInfo* channel = find_channel(e.channel);
      const schema::Type* type = channel ? Schema::builtin().find(channel->type) : nullptr;
      s += ",\"message\":" + (type ? firn::to_json(*type, e.bytes) : "null");
      break;
    }
    case EventKind::kWake:
      s += ",\"due_us\":" + std::to_string(e.due.us);
      break;
    case EventKind::kIo:
      s += ",\"size\":" + std::to_string(e.bytes.size()) +
           ",\"bytes\":" + json_string(escaped(e.bytes, kBytesTold));
      break;
    case EventKind::kLink:
      s += std::string(",\"link\":") + (e.link == LinkState::kOpen ? "\"open\"" : "\"closed\"");
      break;
    case EventKind::kLocalStop:
    case EventKind::kRefused:
      s += ",\"cause\":" + json_string(escaped(e.bytes, kBytesTold));
      break;
  }
  return s + '}';
}

std::string escaped(std::span<const std::byte> bytes, std::size_t at_most) {
  std::string s;
  for (std::byte b : bytes.first(std::min(bytes.size(), at_most))) {
    const auto c = static_cast<unsigned char>(b);
    if (c == '\r')
      s += "\\r";
    else if (c == '\n')
      s += "\\n";
    else if (c >= 0x20 && c < 0x7f && c != '\\')
      s += char(c);
    else {
      char hex[8];
      std::snprintf(hex, sizeof hex, "\\x%02x", c);
      s += hex;
    }
  }
  return bytes.size() > at_most ? s + "..." : s;
}

}  // namespace firn::runs
