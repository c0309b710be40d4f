#include "files/certificate_file.h"

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace firn {
namespace {

constexpr std::size_t kPatterns = 64;

std::string header_of(std::size_t cuts, int nx) {
  std::string dict = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(cuts) + ", " +
                     std::to_string(nx) + ", 64), }";
  while ((10 + dict.size() + 1) % 64) dict += ' ';
  dict += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  head += char(dict.size() & 0xff);
  head += char(dict.size() >> 8);
  return head + dict;
}

}  // namespace

std::vector<std::byte> certificate_bytes(std::span<const float> multipliers, int nx) {
  const std::string head = header_of(multipliers.size() / (std::size_t(nx) * kPatterns), nx);
  std::vector<std::byte> out(head.size() + multipliers.size_bytes());
  std::memcpy(out.data(), head.data(), head.size());
  if (!multipliers.empty())
    std::memcpy(out.data() + head.size(), multipliers.data(), multipliers.size_bytes());
  return out;
}

std::vector<float> certificate_from(std::span<const std::byte> bytes, int nx, const std::string& name) {
  // The header must equal the one written above, for the number of cuts given by the length.
  const std::size_t per_cut = std::size_t(nx) * kPatterns * sizeof(float);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.substr(0, 6) != std::string_view("\x93NUMPY", 6))
    throw std::invalid_argument(name + ": byte 0: not an NPY file (magic missing)");
  const std::size_t newline = text.find('\n'), begin = newline == text.npos ? text.size() : newline + 1;
  const std::size_t cuts = (text.size() - begin) / per_cut;
  if (text.substr(0, begin) != header_of(cuts, nx) || begin + cuts * per_cut != text.size())
    throw std::invalid_argument(name + ": byte 10: not an array of float32 (cuts, " + std::to_string(nx) +
                                ", 64)");
  std::vector<float> multipliers(cuts * std::size_t(nx) * kPatterns);
  if (!multipliers.empty())
    std::memcpy(multipliers.data(), text.data() + begin, multipliers.size() * sizeof(float));
  for (std::size_t i = 0; i < multipliers.size();
       ++i)  // a minimum would ignore a pattern of NaN, which then bounds nothing
    if (!std::isfinite(multipliers[i]))
      throw std::invalid_argument(name + ": byte " + std::to_string(begin + i * sizeof(float)) +
                                  ": a multiplier is not a finite number");
  return multipliers;
}

}  // namespace firn
