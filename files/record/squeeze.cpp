// The shorter writing of record files. Items, little endian:
//   1, u16 kind, u32 length, payload   a record whose index is one more than that of the record before
//   2, u64 index                       the index that the next record has
//   0, u32 length, bytes               bytes as they are
#include <algorithm>
#include <cstring>
#include <limits>

#include "files/record/packed.h"
#include "files/record/record_layout.h"

namespace firn::logfile {
namespace {

enum Item : std::uint8_t { kBytes = 0, kRecord = 1, kIndex = 2 };

class Writer {
 public:
  explicit Writer(std::size_t about) { out_.reserve(about); }
  template <class T>
  void number(T value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    out_.insert(out_.end(), bytes.begin(), bytes.end());
  }
  void bytes(std::span<const std::byte> b) { out_.insert(out_.end(), b.begin(), b.end()); }
  std::vector<std::byte> take() { return std::move(out_); }

 private:
  std::vector<std::byte> out_;
};

class Source {
 public:
  explicit Source(std::span<const std::byte> bytes) : left_(bytes) {}
  bool empty() const { return left_.empty(); }
  std::size_t left() const { return left_.size(); }
  template <class T>
  bool number(T& value) {
    if (left_.size() < sizeof value) return false;
    std::memcpy(&value, left_.data(), sizeof value);
    left_ = left_.subspan(sizeof value);
    return true;
  }
  bool bytes(std::size_t n, std::span<const std::byte>& b) {
    if (left_.size() < n) return false;
    b = left_.first(n);
    left_ = left_.subspan(n);
    return true;
  }

 private:
  std::span<const std::byte> left_;
};

RecordLayout layout_of(std::uint16_t kind, std::uint64_t index, std::span<const std::byte> payload) {
  RecordLayout r{kSyncMarker, kind, 0, std::uint32_t(payload.size()), index, 0};
  r.check = r.expected_check();
  r.checksum = checksum64(r.covered(), {&payload, 1});
  return r;
}

// The payload of the record at the beginning of `bytes`; false if it is not written as layout_of() writes it.
bool record_at(std::span<const std::byte> bytes, RecordLayout& r, std::span<const std::byte>& payload) {
  if (bytes.size() < sizeof r) return false;
  std::memcpy(&r, bytes.data(), sizeof r);
  if (r.sync != kSyncMarker || bytes.size() < sizeof r + padded(r.length)) return false;
  payload = bytes.subspan(sizeof r, r.length);
  const auto padding = bytes.subspan(sizeof r + r.length, padded(r.length) - r.length);
  const RecordLayout wanted = layout_of(r.kind, r.index, payload);
  return std::memcmp(&wanted, &r, sizeof r) == 0 &&
         std::ranges::all_of(padding, [](std::byte b) { return b == std::byte(0); });
}

}  // namespace

std::vector<std::byte> squeeze_records(std::span<const std::byte> plain) {
  Writer out(plain.size());
  std::uint64_t next = 0;
  std::size_t at = 0, kept = 0;  // from `kept` to `at`: bytes as they are
  const auto keep = [&] {
    while (kept < at) {
      const std::size_t n = std::min<std::size_t>(at - kept, std::numeric_limits<std::uint32_t>::max());
      out.number(kBytes);
      out.number(std::uint32_t(n));
      out.bytes(plain.subspan(kept, n));
      kept += n;
    }
  };
  while (at < plain.size()) {
    RecordLayout r;
    std::span<const std::byte> payload;
    if (!record_at(plain.subspan(at), r, payload)) {
      ++at;
      continue;
    }
    keep();
    if (r.index != next) {
      out.number(kIndex);
      out.number(r.index);
    }
    out.number(kRecord);
    out.number(r.kind);
    out.number(r.length);
    out.bytes(payload);
    next = r.index + 1;
    at += sizeof r + padded(r.length);
    kept = at;
  }
  keep();
  return out.take();
}

bool is_one_piece(std::span<const std::byte> squeezed) {
  static_assert(kPieceHeadBytes == sizeof(std::uint8_t) + sizeof(std::uint32_t));
  Source in(squeezed);
  std::uint8_t item = 0;
  std::uint32_t length = 0;
  return in.number(item) && item == kBytes && in.number(length) && length == in.left();
}

bool restore_records(std::span<const std::byte> squeezed, std::span<std::byte> plain,
                     const std::function<void(std::size_t read, std::size_t written)>& done) {
  constexpr std::size_t kStep_bytes = 16 << 20;
  Source in(squeezed);
  std::uint64_t next = 0;
  std::size_t at = 0, told = 0;
  const auto put = [&](std::span<const std::byte> b, std::size_t padding) {
    if (plain.size() - at < b.size() + padding) return false;
    while (!b.empty()) {
      const auto step = b.first(std::min(b.size(), kStep_bytes));
      std::memcpy(plain.data() + at, step.data(), step.size());
      at += step.size();
      b = b.subspan(step.size());
      if (done && at >= told + kStep_bytes) {
        done(squeezed.size() - in.left() - b.size(), at);
        told = at;
      }
    }
    std::fill_n(plain.data() + at, padding, std::byte(0));
    at += padding;
    return true;
  };
  while (!in.empty()) {
    std::uint8_t item = 0;
    std::uint16_t kind = 0;
    std::uint32_t length = 0;
    std::span<const std::byte> bytes;
    in.number(item);
    if (item == kIndex) {
      if (!in.number(next)) return false;
    } else if (item == kBytes) {
      if (!in.number(length) || !in.bytes(length, bytes) || !put(bytes, 0)) return false;
    } else if (item == kRecord) {
      if (!in.number(kind) || !in.number(length) || !in.bytes(length, bytes)) return false;
      const RecordLayout r = layout_of(kind, next++, bytes);
      if (!put(std::as_bytes(std::span(&r, 1)), 0) || !put(bytes, padded(length) - length)) return false;
    } else {
      return false;
    }
  }
  return at == plain.size();
}

}  // namespace firn::logfile
