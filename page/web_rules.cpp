#include "page/web_rules.h"

#include <algorithm>

#include "core/options/number.h"
#include "files/lowercase.h"
#include "page/client_frame.h"

namespace firn::page {
namespace {

constexpr std::size_t kMaxParts = 8, kMostShown = 100;

/// A header's text as an answer may repeat it.
std::string shown(std::string_view text) {
  std::string plain;
  for (const char c : text.substr(0, kMostShown)) plain += c > 0x20 && c < 0x7f ? c : '?';
  return plain.empty() ? "(none)" : plain;
}

}  // namespace

std::vector<std::string> own_authorities(const std::string& bind, int port,
                                         const std::vector<std::string>& hosts) {
  const std::string colon = ":" + std::to_string(port);
  std::vector<std::string> own{"127.0.0.1" + colon, "localhost" + colon, "[::1]" + colon};
  const bool any = bind == "0.0.0.0" || bind == "::";
  if (!any) own.push_back((bind.find(':') == bind.npos ? bind : "[" + bind + "]") + colon);
  for (const std::string& host : hosts) own.push_back(lowercase(host));
  return own;
}

bool host_allowed(std::string_view host, const std::vector<std::string>& own) {
  return std::ranges::find(own, lowercase(host)) != own.end();
}

bool origin_allowed(std::string_view origin, const std::vector<std::string>& own) {
  if (origin.empty()) return true;
  for (const std::string_view scheme : {"http://", "https://"})
    if (origin.starts_with(scheme)) return host_allowed(origin.substr(scheme.size()), own);
  return false;
}

std::string foreign_words(std::string_view host, std::string_view origin,
                          const std::vector<std::string>& own) {
  const bool foreign_host = !host_allowed(host, own);
  if (!foreign_host && origin_allowed(origin, own)) return {};
  const std::string_view authority =
      foreign_host ? host : origin.substr(std::min(origin.find("//") + 2, origin.size()));
  return std::string(foreign_host ? "Host " : "Origin ") + shown(foreign_host ? host : origin) +
         " is not this page's: behind a proxy start it with --host " + shown(authority);
}

std::vector<std::string> path_parts(std::string_view target) {
  target = target.substr(0, target.find_first_of("?#"));
  std::vector<std::string> parts;
  if (!target.starts_with('/')) return {};
  target.remove_prefix(1);
  while (true) {
    const std::size_t slash = target.find('/');
    const std::string_view raw = target.substr(0, slash);
    std::string part;
    for (std::size_t n = 0; n < raw.size(); ++n) {
      if (raw[n] != '%') {
        part += raw[n];
        continue;
      }
      if (n + 2 >= raw.size()) return {};
      const std::optional<std::uint8_t> value = hex_byte(raw.substr(n + 1, 2));
      if (!value) return {};
      part += char(*value);
      n += 2;
    }
    const bool bad =
        part == ".." || part == "." || part.find('/') != part.npos || part.find('\0') != part.npos;
    if (bad || parts.size() == kMaxParts) return {};
    parts.push_back(std::move(part));
    if (slash == target.npos) return parts;
    target.remove_prefix(slash + 1);
  }
}

namespace {

// Values of the key in a target's query, as they are on the wire.
std::vector<std::string_view> raw_values(std::string_view target, std::string_view key) {
  std::vector<std::string_view> values;
  std::size_t at = target.find('?');
  while (at != target.npos) {
    target.remove_prefix(at + 1);
    at = target.find('&');
    const std::string_view pair = target.substr(0, at);
    const std::size_t equals = pair.find('=');
    if (equals != pair.npos && pair.substr(0, equals) == key) values.push_back(pair.substr(equals + 1));
  }
  return values;
}

}  // namespace

std::vector<std::string> query_values(std::string_view target, std::string_view key) {
  std::vector<std::string> values;
  for (const std::string_view raw : raw_values(target, key)) {
    auto parts = path_parts("/" + std::string(raw));
    values.push_back(parts.size() == 1 ? std::move(parts.front()) : "");
  }
  return values;
}

std::string query_text(std::string_view target, std::string_view key) {
  const auto raw = raw_values(target, key);
  std::string text;
  for (std::string_view rest = raw.empty() ? "" : raw.front(); !rest.empty(); rest.remove_prefix(1)) {
    const auto value = rest[0] == '%' && rest.size() > 2 ? hex_byte(rest.substr(1, 2)) : std::nullopt;
    text += value ? char(*value) : rest[0];
    if (value) rest.remove_prefix(2);
  }
  return text;
}

std::string run_of(std::string_view target) {
  const auto ids = query_values(target, "run");
  return ids.empty() ? "live" : ids.front();
}

std::vector<std::string_view> list_words(std::string_view header) {
  std::vector<std::string_view> words;
  while (!header.empty()) {
    const std::size_t comma = std::min(header.find(','), header.size());
    std::string_view word = header.substr(0, comma);
    while (word.starts_with(' ')) word.remove_prefix(1);
    while (word.ends_with(' ')) word.remove_suffix(1);
    if (!word.empty()) words.push_back(word);
    header.remove_prefix(std::min(comma + 1, header.size()));
  }
  return words;
}

std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kBearer = "Bearer ";
  return authorization.starts_with(kBearer) ? authorization.substr(kBearer.size()) : std::string_view();
}

std::vector<std::string_view> cookie_tokens(std::string_view cookies) {
  constexpr std::string_view kCookie = "firn-";
  std::vector<std::string_view> tokens;
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    std::string_view one = cookies.substr(0, end);
    while (one.starts_with(' ')) one.remove_prefix(1);
    const std::size_t equals = one.find('=');
    if (one.starts_with(kCookie) && equals != one.npos) tokens.push_back(one.substr(equals + 1));
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
  }
  return tokens;
}

}  // namespace firn::page
