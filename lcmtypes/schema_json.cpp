#include <charconv>
#include <cmath>

#include "lcmtypes/schema_walk.h"
#include "lcmtypes/utf8.h"

namespace firn {

using namespace schema;

namespace {

constexpr std::size_t kShownOfLong = 8;

void append_number(std::string& out, Kind kind, const std::byte* p) {
  char text[40];
  std::to_chars_result r{};
  if (kind == Kind::kFloat || kind == Kind::kDouble) {
    const double v = real_at(kind, p);
    if (!std::isfinite(v)) {
      out += std::isnan(v) ? "null" : v > 0 ? "\"Infinity\"" : "\"-Infinity\"";
      return;
    }
    r = kind == Kind::kFloat ? std::to_chars(text, text + sizeof text, float(v))
                             : std::to_chars(text, text + sizeof text, v);
  } else {
    r = std::to_chars(text, text + sizeof text, integer_at(kind, p));
  }
  out.append(text, r.ptr);
}

// Members of structs that stand alone have dotted paths: opens and closes objects as the paths change.
struct JsonSink : NullSink {
  std::span<const std::byte> message;
  JsonOptions options;
  std::string out = "{";
  std::vector<std::string> open = {};  // of the object or element in hand
  std::vector<std::vector<std::string>> outer;
  std::string_view array_end;  // of the array of strings in hand

  void comma() {
    if (out.back() != '{' && out.back() != '[') out += ',';
  }
  void close_to(std::size_t depth) {
    for (; open.size() > depth; open.pop_back()) out += '}';
  }
  // Writes `"name":` inside the right object.
  void name(std::string_view path) {
    std::size_t depth = 0;
    for (std::size_t dot; (dot = path.find('.')) != path.npos; path.remove_prefix(dot + 1), ++depth) {
      const std::string_view part = path.substr(0, dot);
      if (depth < open.size() && open[depth] == part) continue;
      close_to(depth);
      comma();
      out += json_string(part) + ":{";
      open.emplace_back(part);
    }
    close_to(depth);
    comma();
    out += json_string(path) + ":";
  }
  std::size_t shown(std::size_t n) const {
    return options.full || n <= options.array_limit ? n : kShownOfLong;
  }
  void open_array(std::size_t n) {
    out += shown(n) == n ? "[" : "{\"count\":" + std::to_string(n) + ",\"first\":[";
  }
  void close_array(std::size_t n) { out += array_end_of(n); }
  std::string_view array_end_of(std::size_t n) const { return shown(n) == n ? "]" : "]}"; }

  void numbers(const Field& f, std::size_t, std::size_t offset, const Counts& c) {
    name(f.path);
    if (c.rank == 0) return append_number(out, f.kind, message.data() + offset);
    open_array(c.total);
    for (std::size_t k = 0; k < shown(c.total); ++k) {
      if (k) out += ',';
      append_number(out, f.kind, message.data() + offset + k * kSizes[std::size_t(f.kind)]);
    }
    close_array(c.total);
  }
  void strings(const Field& f, std::size_t, std::size_t, const Counts& c) {
    name(f.path);
    if (c.rank == 0) return;
    open_array(c.total);
    array_end = array_end_of(c.total);
  }
  void string(const Field&, std::size_t, std::string_view text, const Counts& c, std::size_t k) {
    if (k >= shown(c.total)) return;
    if (k) out += ',';
    out += json_string(text);
  }
  void end_strings(const Field&, const Counts& c) {
    close_array(c.total);
    array_end = {};
  }
  void elements(const Field& f, const Counts& c) {
    name(f.path);
    out += c.total == 0 ? "[]" : "[";
  }
  void element(const Field&, const Counts&, std::size_t) {
    comma();
    out += '{';
    outer.push_back(std::move(open));
    open.clear();
  }
  void end_element(const Field&, const Counts& c, std::size_t k) {
    close_to(0);
    open = std::move(outer.back());
    outer.pop_back();
    out += k + 1 == c.total ? "}]" : "}";
  }
};

}  // namespace

std::string json_string(std::string_view text) {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string out = "\"";
  while (!text.empty()) {
    const unsigned char c = static_cast<unsigned char>(text[0]);
    const std::size_t n = utf8_length(text);
    if (n == 0)
      out += "\xef\xbf\xbd";
    else if (c == '"' || c == '\\')
      (out += '\\') += char(c);
    else if (c == '\n')
      out += "\\n";
    else if (c == '\t')
      out += "\\t";
    else if (c < 0x20 || c == 0x7f)
      ((out += "\\u00") += kHex[c >> 4]) += kHex[c & 15];
    else
      out += text.substr(0, n);
    text.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return out += '"';
}

std::string to_json(const Type& type, std::span<const std::byte> message, const JsonOptions& options) {
  JsonSink sink;
  sink.message = message;
  sink.options = options;
  const auto error = walk_message(type, message, sink);
  if (error) {
    // Whatever was open is closed; damage inside an array leaves the elements before it.
    sink.out += sink.array_end;
    while (true) {
      sink.close_to(0);
      if (sink.outer.empty()) break;
      sink.out += "}]";
      sink.open = std::move(sink.outer.back());
      sink.outer.pop_back();
    }
    sink.comma();
    sink.out += "\"_error\":" + json_string((error->path.empty() ? "" : error->path + ": ") + "byte " +
                                            std::to_string(error->offset) + ": " + error->message);
  } else {
    sink.close_to(0);
  }
  return sink.out + "}";
}

}  // namespace firn
