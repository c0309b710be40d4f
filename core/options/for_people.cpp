#include "core/options/for_people.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "core/options/number.h"

namespace firn {
namespace {

constexpr int kDigits = 3;
constexpr int kMostDecimals = 12;
constexpr std::size_t kRecordedDecimals = 6;  // of std::to_string(double)

bool digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string thousands_apart(std::string digits) {
  for (std::size_t at = digits.size(); at > 3 && digit(digits[at - 4]);) digits.insert(at -= 3, ",");
  return digits;
}

}  // namespace

std::string for_people(double value) {
  if (!std::isfinite(value)) return "-";
  char text[400];
  if (std::abs(value) >= 999.5) {
    std::snprintf(text, sizeof text, "%.0f", value);
    return thousands_apart(text);
  }
  std::snprintf(text, sizeof text, "%.*e", kDigits - 1, value);  // rounded first: 9.996 is 10.0
  const std::string_view rounded = text;
  const int power = whole_number<int>(rounded.substr(rounded.find('e') + 1)).value_or(0);
  std::snprintf(text, sizeof text, "%.*f", std::clamp(kDigits - 1 - power, 0, kMostDecimals),
                whole_number<double>(rounded).value_or(value));
  std::string s = text;
  if (s.find('.') != s.npos) s.erase(s.find_last_not_of('0') + 1);
  if (s.ends_with('.')) s.pop_back();
  return s == "-0" ? "0" : s;
}

std::string time_for_people(double s) {
  constexpr double kMostSeconds = 120.0, kMinute_s = 60.0;
  if (!std::isfinite(s) || std::abs(s) < 10.0) return for_people(s) + " s";
  if (std::abs(s) < kMostSeconds) return for_people(std::round(s)) + " s";
  if (std::abs(s) < 2.0 * kHour_s) return for_people(std::round(s / kMinute_s)) + " min";
  return for_people(std::round(s / kHour_s * 10.0) / 10.0) + " h";
}

std::string grouped(std::uint64_t n) { return thousands_apart(std::to_string(n)); }

std::string counted(std::uint64_t n, std::string_view one, std::string_view many) {
  std::string s = grouped(n) + " ";
  if (n == 1) return s.append(one);
  return many.empty() ? s.append(one) + "s" : s.append(many);
}

std::string for_people(std::string_view sentence) {
  std::string s;
  for (std::size_t at = 0; at < sentence.size();) {
    std::size_t end = at;
    while (end < sentence.size() && digit(sentence[end])) ++end;
    const std::size_t point = end;
    if (end > at && end < sentence.size() && sentence[end] == '.')
      while (++end < sentence.size() && digit(sentence[end])) {
      }
    if (end == at) {
      s += sentence[at++];
      continue;
    }
    const std::string_view number = sentence.substr(at, end - at);
    const bool recorded = end - point == kRecordedDecimals + 1;
    s += recorded ? for_people(whole_number<double>(number).value_or(0.0)) : std::string(number);
    at = end;
  }
  return s;
}

}  // namespace firn
