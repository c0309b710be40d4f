// ByteBlocks reads a stream block by block, for readers that look ahead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <vector>

namespace firn {

class ByteBlocks {
 public:
  explicit ByteBlocks(std::istream& in) : in_(*in.rdbuf()), bytes_(kBlock) {}

  /// The buffered bytes that have not been taken.
  const char* begin() const { return bytes_.data() + at_; }
  const char* end() const { return bytes_.data() + filled_; }
  std::size_t size() const { return filled_ - at_; }
  void take(std::size_t count) { at_ += count; }
  std::uint64_t position() const { return before_ + at_; }  ///< bytes taken so far

  /// Appends to the buffered bytes and moves them, so that pointers become invalid. Returns false at the end
  /// of the stream.
  bool more() {
    before_ += at_;
    std::copy(bytes_.begin() + std::ptrdiff_t(at_), bytes_.begin() + std::ptrdiff_t(filled_), bytes_.begin());
    filled_ -= at_;
    at_ = 0;
    if (filled_ == bytes_.size()) bytes_.resize(2 * bytes_.size());
    const auto got = in_.sgetn(bytes_.data() + filled_, std::streamsize(bytes_.size() - filled_));
    filled_ += std::size_t(got);
    return got > 0;
  }

  int peek() { return size() > 0 || more() ? static_cast<unsigned char>(bytes_[at_]) : -1; }

 private:
  static constexpr std::size_t kBlock = 1 << 18;
  std::streambuf& in_;
  std::vector<char> bytes_;
  std::size_t at_ = 0, filled_ = 0;
  std::uint64_t before_ = 0;
};

}  // namespace firn
