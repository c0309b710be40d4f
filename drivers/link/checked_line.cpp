#include "drivers/link/checked_line.h"

#include <charconv>
#include <cstring>

#include "core/options/number.h"
#include "drivers/link/crc16.h"

namespace firn::drivers {

LineWriter& LineWriter::text(std::string_view text) {
  if (text.size() > room()) {
    overflow_ = true;
    return *this;
  }
  std::memcpy(line_.data() + size_, text.data(), text.size());
  size_ += text.size();
  return *this;
}

LineWriter& LineWriter::number(std::int64_t value) {
  char digits[24];
  const auto r = std::to_chars(digits, digits + sizeof digits, value);
  return text({digits, std::size_t(r.ptr - digits)});
}

std::string_view LineWriter::finish(std::size_t from) {
  const std::uint16_t crc = crc16(so_far().substr(from));
  line_[size_] = '*';
  put_hex4(line_.data() + size_ + 1, crc);
  line_[size_ + 5] = '\r';
  line_[size_ + 6] = '\n';
  size_ += kEnd;
  return so_far();
}

std::optional<std::string_view> checked_text(std::string_view line, std::size_t from) {
  if (!line.empty() && line.back() == '\n') line.remove_suffix(1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  if (line.size() < from + 5 || line[line.size() - 5] != '*') return std::nullopt;
  const std::string_view text = line.substr(from, line.size() - 5 - from);
  if (hex4(line.substr(line.size() - 4)) != int(crc16(text))) return std::nullopt;
  return text;
}

std::string_view WordReader::word() {
  while (!rest_.empty() && rest_.front() == between_) rest_.remove_prefix(1);
  const std::string_view found = rest_.substr(0, rest_.find(between_));
  rest_.remove_prefix(found.size());
  return found;
}

std::int64_t WordReader::number(std::int64_t low, std::int64_t high) {
  const std::optional<std::int64_t> value = whole_number(word(), low, high);
  if (!value) good_ = false;
  return value.value_or(low);
}

}  // namespace firn::drivers
