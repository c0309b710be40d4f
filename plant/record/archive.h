// Archive writes and reads the whole state of a type through one function, `void io(Archive&)`. A loaded
// state equals the saved state bit for bit, so that nature continues from it.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace firn::plant {

/// True for numbers, enums and structures that hold nothing else: any bytes are a value of them. A bool has
/// two values only, and a class may have rules of its own.
template <class T>
constexpr bool is_plain();

template <std::size_t>
struct AnyField {
  template <class T>
  operator T() const;
};
template <class Owner>
struct OtherField {
  template <class T>
  requires(!std::same_as<T, Owner>) && (!is_plain<T>()) operator T() const;
};
template <class T, std::size_t... Before>
constexpr bool is_other_after(std::index_sequence<Before...>) {
  return requires { T{AnyField<Before>{}..., OtherField<T>{}}; };
}
template <class T, std::size_t... N>
constexpr bool has_other_field(std::index_sequence<N...>) {
  return (is_other_after<T>(std::make_index_sequence<N>{}) || ...);
}

template <class T>
constexpr bool is_plain() {
  if constexpr (std::is_aggregate_v<T> && std::is_class_v<T>)
    return !has_other_field<T>(std::make_index_sequence<32>{});
  else
    return std::is_enum_v<T> || (std::is_arithmetic_v<T> && !std::same_as<T, bool>);
}

class Archive;
template <class T>
concept HasIo = requires(T& t, Archive& a) {
  t.io(a);
};

class Archive {
 public:
  Archive() = default;  ///< for saving
  explicit Archive(std::vector<std::byte> bytes) : bytes_(std::move(bytes)), loading_(true) {}

  bool loading() const { return loading_; }
  const std::vector<std::byte>& bytes() const { return bytes_; }

  template <class T>
  requires(std::is_trivially_copyable_v<T> && !HasIo<T>) void operator()(T& value) {
    static_assert(is_plain<T>(), "needs io(Archive&): not all bytes of a damaged file are a value of it");
    if (loading_) return raw(&value, sizeof value);
    T saved = value;
#if __has_builtin(__builtin_clear_padding)  // clang, for fuzzing, has it not
    __builtin_clear_padding(&saved);  // equal states are equal files, and no stray bytes of memory in them
#endif
    raw(&saved, sizeof saved);
  }
  void operator()(bool& value) {
    std::uint8_t byte = value ? 1 : 0;
    raw(&byte, 1);
    if (byte > 1)
      throw std::runtime_error("world state: neither true nor false at byte " + std::to_string(at_ - 1));
    value = byte == 1;
  }
  template <std::size_t N>
  void operator()(std::array<bool, N>& values) {
    for (bool& v : values) operator()(v);
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    sequence(values);
  }
  template <class T>
  void operator()(std::deque<T>& values) {
    sequence(values);
  }
  void operator()(std::string& text) {
    std::uint64_t n = length(text.size());
    text.resize(n);
    raw(text.data(), n);
  }
  template <HasIo T>
  void operator()(T& value) {
    value.io(*this);
  }
  template <class... T>
  void all(T&... values) {
    (operator()(values), ...);
  }

  /// Writes or checks a marker between parts. @throws std::runtime_error naming the marker when a loaded file
  /// lacks it here
  void tag(std::uint32_t expected, const char* what) {
    std::uint32_t found = expected;
    raw(&found, sizeof found);
    if (found != expected) throw std::runtime_error(std::string("world state: damaged before ") + what);
  }
  void expect_end() const {
    if (loading_ && at_ != bytes_.size()) throw std::runtime_error("world state: bytes left over at the end");
  }

 private:
  template <class C>
  void sequence(C& values) {
    const std::uint64_t n = length(values.size());
    if (loading_) values = C(n);
    for (auto& v : values) operator()(v);
  }
  std::uint64_t length(std::size_t size) {
    std::uint64_t n = size;
    raw(&n, sizeof n);
    if (loading_ && n > bytes_.size() - at_) throw std::runtime_error("world state: cut short");
    return n;
  }
  void raw(void* data, std::size_t n) {
    if (!loading_) {
      const auto* from = static_cast<const std::byte*>(data);
      bytes_.insert(bytes_.end(), from, from + n);
      return;
    }
    if (n > bytes_.size() - at_) throw std::runtime_error("world state: cut short");
    if (n != 0) std::memcpy(data, bytes_.data() + at_, n);
    at_ += n;
  }

  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
  bool loading_ = false;
};

}  // namespace firn::plant
