// Holds a folder for the files of one test, a seeded generator, and damage to bytes.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace firn::test {

using Bytes = std::vector<std::byte>;

class Scratch {
 public:
  explicit Scratch(const std::string& name)
      : folder_(std::filesystem::temp_directory_path() /
                ("firn-" + name + "-" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::filesystem::path operator/(const std::string& file) const { return folder_ / file; }

 private:
  std::filesystem::path folder_;
};

inline Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}

inline void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

/// SplitMix64 [Steele et al. 2014].
struct Random {
  std::uint64_t state;
  std::uint64_t operator()() {
    std::uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
  }
  std::uint64_t below(std::uint64_t n) { return (*this)() % n; }
};

inline Bytes random_bytes(Random& random, std::size_t n) {
  Bytes b(n);
  for (std::byte& x : b) x = std::byte(random());
  return b;
}

inline Bytes cut_from(const Bytes& b, std::size_t at, std::size_t n) {
  Bytes out(b.begin(), b.begin() + std::ptrdiff_t(at));
  out.insert(out.end(), b.begin() + std::ptrdiff_t(std::min(at + n, b.size())), b.end());
  return out;
}

inline Bytes with_zeros(Bytes b, std::size_t at, std::size_t n) {
  for (std::size_t i = at; i < std::min(at + n, b.size()); ++i) b[i] = std::byte{0};
  return b;
}

/// The block [from, from + n) once more, inserted at `at`.
inline Bytes with_copy(const Bytes& b, std::size_t from, std::size_t n, std::size_t at) {
  Bytes out(b.begin(), b.begin() + std::ptrdiff_t(at));
  out.insert(out.end(), b.begin() + std::ptrdiff_t(from),
             b.begin() + std::ptrdiff_t(std::min(from + n, b.size())));
  out.insert(out.end(), b.begin() + std::ptrdiff_t(at), b.end());
  return out;
}

inline std::span<const std::byte> as_span(std::string_view text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

}  // namespace firn::test
