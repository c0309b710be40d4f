#include "replay/message_compare.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace firn::replay {
namespace {

std::string hex(std::byte b) {
  char text[8];
  std::snprintf(text, sizeof text, "0x%02x", unsigned(b));
  return text;
}

}  // namespace

Ignore parse_ignore(const std::string& text) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw std::invalid_argument("--ignore " + text +
                                ": FIELD=reason is wanted, and the reason must be given");
  return {text.substr(0, at), text.substr(at + 1)};
}

FieldDifference byte_difference(std::span<const std::byte> a, std::span<const std::byte> b) {
  const auto [x, y] = std::ranges::mismatch(a, b);
  const std::string byte = "byte " + std::to_string(x - a.begin());
  return {byte, x == a.end() ? "end" : hex(*x), y == b.end() ? "end" : hex(*y), std::size_t(x - a.begin())};
}

MessageComparer::MessageComparer(const ReplayOptions& options) : tolerance_(options.tolerance) {
  for (const Ignore& i : options.ignores) ignored_.push_back({i.field, i.reason, 0});
}

bool MessageComparer::ignores(std::string_view channel, std::string_view path) {
  const std::string_view field = path.substr(0, path.find('['));
  for (Ignored& i : ignored_)
    if (i.field == field ||
        (i.field.size() == channel.size() + 1 + field.size() && i.field.starts_with(channel) &&
         i.field[channel.size()] == '.' && i.field.ends_with(field))) {
      ++i.times;
      return true;
    }
  return false;
}

bool MessageComparer::within_tolerance(std::string_view channel, const Leaf& a, const LeafValue& b) {
  if (tolerance_ <= 0 || a.value.index() != b.index() || std::holds_alternative<std::string_view>(b))
    return false;
  const auto number = [](const LeafValue& v) {
    return std::holds_alternative<double>(v) ? std::get<double>(v) : double(std::get<std::int64_t>(v));
  };
  const double difference = std::abs(number(a.value) - number(b));
  if (!(difference <= tolerance_)) return false;
  if (difference > largest_) {
    largest_ = difference;
    largest_field_ = std::string(channel) + "." + std::string(a.path);
  }
  return true;
}

std::optional<FieldDifference> MessageComparer::compare(const ChannelInfo& channel,
                                                        std::span<const std::byte> a,
                                                        std::span<const std::byte> b) {
  const schema::Type* type = Schema::builtin().find(channel.type);
  if (!type) return byte_difference(a, b);
  const auto first = first_difference(*type, a, b);
  if (!first || (tolerance_ <= 0 && ignored_.empty())) return first;

  // Leaf by leaf. Where arrays have other lengths the leaves do not match: the first difference is kept.
  values_.clear();
  const auto keep = [this](const Leaf& leaf) {
    values_.push_back({leaf.value, leaf.offset, leaf.bytes});
    return true;
  };
  if (for_each_leaf(*type, b, keep)) return first;
  std::optional<FieldDifference> found;
  std::size_t n = 0;
  const auto compare_leaf = [&](const Leaf& leaf) {
    if (n == values_.size()) {
      ++n;
      return false;
    }
    const Value& v = values_[n++];
    Leaf other = leaf;
    other.value = v.value;
    const bool same = std::ranges::equal(a.subspan(leaf.offset, leaf.bytes), b.subspan(v.offset, v.bytes));
    if (!same && !ignores(channel.name, leaf.path) && !within_tolerance(channel.name, leaf, v.value))
      found = FieldDifference{std::string(leaf.path), to_text(leaf), to_text(other), leaf.offset};
    return !found;
  };
  const bool damaged = for_each_leaf(*type, a, compare_leaf).has_value();
  if (damaged || (!found && n != values_.size())) return first;
  return found;
}

}  // namespace firn::replay
