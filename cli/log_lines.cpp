#include "cli/log_lines.h"

#include <algorithm>

#include "cli/message_types.h"
#include "core/options/enumerators.h"
#include "runtime/write_ahead.h"

namespace firn {
namespace {

class Line {
 public:
  Line& add(std::string_view name, const std::string& json) {
    text_ += (text_.size() > 1 ? "," : "") + json_string(name) + ":" + json;
    return *this;
  }
  Line& text(std::string_view name, std::string_view value) { return add(name, json_string(value)); }
  Line& number(std::string_view name, std::int64_t value) { return add(name, std::to_string(value)); }
  std::string end() const { return text_ + "}"; }

 private:
  std::string text_ = "{";
};

std::string hex(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (const std::byte b : bytes) (out += kDigits[unsigned(b) >> 4]) += kDigits[unsigned(b) & 15];
  return out;
}

// Bytes to or from an instrument: text where they are text.
void add_bytes(Line& line, std::span<const std::byte> bytes, const LineOptions& options) {
  const std::size_t most = options.full ? bytes.size() : std::min<std::size_t>(bytes.size(), 80);
  const auto shown = bytes.first(most);
  const bool printable = std::all_of(shown.begin(), shown.end(), [](std::byte b) {
    return (unsigned(b) >= 0x20 && unsigned(b) < 0x7f) || b == std::byte{'\r'} || b == std::byte{'\n'};
  });
  line.number("count", std::int64_t(bytes.size()));
  if (printable)
    line.text("text", {reinterpret_cast<const char*>(shown.data()), shown.size()});
  else
    line.text("hex", hex(shown));
}

const MessageTypes& types_of(const LineOptions& options) {
  static const MessageTypes own;
  return options.types ? *options.types : own;
}

void add_unknown(Line& line, std::string_view channel, std::span<const std::byte> message,
                 const LineOptions& options) {
  if (const auto other = not_lcm(channel, message)) {
    line.text("not_lcm", *other);
    add_bytes(line, message, options);
    return;
  }
  line.number("bytes", std::int64_t(message.size())).text("unknown_fingerprint", hex(message.first(8)));
  const MessageTypes::Nearest near = types_of(options).nearest_to(channel, message);
  if (near.type) line.text("nearest", full_name(*near.type)).add("fits", near.fits ? "true" : "false");
}

void add_message(Line& line, std::string_view channel, std::span<const std::byte> message,
                 const LineOptions& options) {
  const std::vector<const schema::Type*>& types = types_of(options).of(message);
  if (types.empty()) return add_unknown(line, channel, message, options);
  const schema::Type& type = *types.front();
  line.text("type", type.origin.empty() ? type.name : full_name(type));
  std::string also;
  for (std::size_t i = 1; i < types.size(); ++i)
    also += (also.empty() ? "" : ",") + json_string(full_name(*types[i]));
  if (!also.empty()) line.add("same_fingerprint", "[" + also + "]");
  line.add("message", to_json(type, message, options));
}

constexpr const char* kEventNames[] = {"?",  "start", "message",    "wake",
                                       "io", "link",  "local_stop", "refused"};
static_assert(std::size(kEventNames) == kTableSize<EventKind>);
constexpr const char* kOutputNames[] = {"?", "send", "write", "arm", "cancel", "reopen", "finish"};
static_assert(std::size(kOutputNames) == kTableSize<OutputKind>);

template <std::size_t N, class Kind>
const char* name_of(const char* const (&names)[N], Kind kind) {
  return std::size_t(kind) < N ? names[std::size_t(kind)] : "?";
}

void add_event(RecordLine& to, Line& line, std::span<const std::byte> payload, const LineOptions& options) {
  const WalEvent e = decode_event(payload);
  to.now_us = e.event.now.us;
  line.number("step", std::int64_t(e.step))
      .number("now_us", e.event.now.us)
      .text("event", name_of(kEventNames, e.event.kind));
  switch (e.event.kind) {
    case EventKind::kStart:
      line.number("incarnation", e.event.incarnation);
      break;
    case EventKind::kMessage:
      to.channels.emplace_back(e.event.channel);
      line.text("channel", e.event.channel);
      add_message(line, e.event.channel, e.event.bytes, options);
      break;
    case EventKind::kWake:
      line.number("timer", e.event.id).number("due_us", e.event.due.us);
      break;
    case EventKind::kIo:
      line.number("port", e.event.id);
      add_bytes(line, e.event.bytes, options);
      break;
    case EventKind::kLink:
      line.number("port", e.event.id).number("open", e.event.link == LinkState::kOpen);
      break;
    case EventKind::kRefused:
      line.number("port", e.event.id);
      add_bytes(line, e.event.bytes, options);
      break;
    case EventKind::kLocalStop:
      add_bytes(line, e.event.bytes, options);
      break;
  }
}

std::string output_json(RecordLine& to, const Output& o, const LineOptions& options) {
  Line line;
  line.text("output", name_of(kOutputNames, o.kind));
  switch (o.kind) {
    case OutputKind::kSend:
      to.channels.emplace_back(o.channel);
      line.text("channel", o.channel);
      add_message(line, o.channel, o.bytes, options);
      break;
    case OutputKind::kArm:
      line.number("timer", o.id).number("at_us", o.at.us);
      break;
    case OutputKind::kCancel:
      line.number("timer", o.id);
      break;
    case OutputKind::kWrite:
    case OutputKind::kFinish:
      line.number(o.kind == OutputKind::kWrite ? "port" : "status", o.id);
      add_bytes(line, o.bytes, options);
      break;
    case OutputKind::kReopen:
      line.number("port", o.id);
      break;
  }
  return line.end();
}

void add_outputs(RecordLine& to, Line& line, std::span<const std::byte> payload, const LineOptions& options) {
  const WalOutputs outputs = decode_outputs(payload);
  line.number("step", std::int64_t(outputs.step)).number("handler_ns", outputs.handler_ns);
  std::string list;
  for (const Output& o : decode_output_list(outputs.body))
    list += (list.empty() ? "" : ",") + output_json(to, o, options);
  line.add("outputs", "[" + list + "]");
}

void add_head(Line& line, std::span<const std::byte> payload, const LineOptions& options) {
  const WalHead head = decode_head(payload);
  line.text("node", head.node).number("run_id", head.run_id).number("incarnation", head.incarnation);
  line.text("commit", head.commit).text("platform", head.platform).text("config_toml", head.config_toml);
  if (options.full) line.text("types", head.type_texts);
  Line blobs;
  for (const auto& [role, sha256] : head.blobs) blobs.text(role, sha256);
  line.add("blobs", blobs.end());
}

}  // namespace

std::string event_line(const record::Event& e, const LineOptions& options) {
  Line line;
  line.number("event", std::int64_t(e.eventnum)).number("utime_us", e.utime_us).text("channel", e.channel);
  if (e.damaged) line.add("damaged", "true").number("offset", std::int64_t(e.offset));
  add_message(line, e.channel, e.data, options);
  return line.end();
}

RecordLine record_line(const record::Record& record, bool write_ahead, const LineOptions& options) {
  RecordLine to;
  Line line;
  line.number("record", std::int64_t(record.index));
  if (record.damaged) line.add("damaged", "true").number("offset", std::int64_t(record.offset));
  const WalKind kind = write_ahead ? WalKind(record.kind) : WalKind(0);
  try {
    switch (kind) {
      case WalKind::kHead:
        line.text("kind", "head");
        add_head(line, record.payload, options);
        break;
      case WalKind::kEvent:
        line.text("kind", "event");
        add_event(to, line, record.payload, options);
        break;
      case WalKind::kOutputs:
        line.text("kind", "outputs");
        add_outputs(to, line, record.payload, options);
        break;
      default:
        line.number("kind", record.kind).number("bytes", std::int64_t(record.payload.size()));
    }
  } catch (const std::runtime_error& e) {
    to.error = e.what();
    line.text("error", to.error);
  }
  to.json = line.end();
  return to;
}

}  // namespace firn
