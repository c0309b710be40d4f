#include "runtime/fingerprint.h"

#include <fmt/core.h>

#include <cstddef>
#include <span>
#include <stdexcept>

#include "core/options/number.h"
#include "files/record/checksum.h"

namespace firn {

std::uint64_t digest_of(const Fingerprint& fingerprint) {
  std::string all;
  for (const auto& [function, digest] : fingerprint) all += fmt::format("{} {:016x}\n", function, digest);
  return record::checksum64(std::as_bytes(std::span(all)));
}

std::vector<std::string> differing_functions(const Fingerprint& a, const Fingerprint& b) {
  std::vector<std::string> names;
  for (const auto& [function, digest] : a)
    if (const auto other = b.find(function); other != b.end() && other->second != digest)
      names.push_back(function);
  return names;
}

std::map<std::string, std::string> fingerprint_texts(const Fingerprint& fingerprint) {
  std::map<std::string, std::string> texts;
  for (const auto& [function, digest] : fingerprint) texts[function] = fmt::format("{:016x}", digest);
  return texts;
}

Fingerprint fingerprint_of(const std::map<std::string, std::string>& texts) {
  constexpr std::size_t kDigits = 16;
  Fingerprint fingerprint;
  for (const auto& [function, text] : texts) {
    const auto digest = text.size() == kDigits ? whole_hex_number<std::uint64_t>(text) : std::nullopt;
    if (!digest)
      throw std::invalid_argument(function + ": '" + text + "' is no digest of 16 hexadecimal digits");
    fingerprint[function] = *digest;
  }
  return fingerprint;
}

}  // namespace firn
