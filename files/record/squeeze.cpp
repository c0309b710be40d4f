// The squeezed form is a sequence of items, little endian:
//   1, u16 kind, u32 length, payload   a record whose index is one more than that of the record before
//   2, u64 index                       the index that the next record has
//   0, u32 length, bytes               bytes as they are
#include "files/record/squeeze.h"

#include <string.h>  // memmem

#include <algorithm>
#include <cstring>
#include <limits>

#include "files/record/record_layout.h"

namespace firn::record {
namespace {

enum Item : std::uint8_t { kBytes = 0, kRecord = 1, kIndex = 2 };
constexpr std::size_t kBytesHead = 1 + 4, kRecordHead = 1 + 2 + 4, kIndexBytes = 1 + 8;

void append(std::vector<std::byte>& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

template <class T>
void append_number(std::vector<std::byte>& out, T value) {
  append(out, std::as_bytes(std::span(&value, 1)));
}

template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

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

// The first record behind byte `from`; the number of bytes without one.
std::size_t find_record(std::span<const std::byte> bytes, std::size_t from) {
  RecordLayout r;
  std::span<const std::byte> payload;
  while (++from < bytes.size()) {
    const void* found =
        ::memmem(bytes.data() + from, bytes.size() - from, kSyncMarker.data(), kSyncMarker.size());
    if (!found) break;
    from = std::size_t(static_cast<const std::byte*>(found) - bytes.data());
    if (record_at(bytes.subspan(from), r, payload)) return from;
  }
  return bytes.size();
}

// The squeezed bytes, or their number alone.
struct Appending {
  std::vector<std::byte>& out;
  std::size_t size() const { return out.size(); }
  void bytes(std::span<const std::byte> b) { append(out, b); }
  template <class T>
  void number(T value) {
    append_number(out, value);
  }
};
struct Counting {
  Squeezer::Counted& counted;
  std::size_t size() const { return counted.squeezed; }
  void bytes(std::span<const std::byte> b) {
    counted.squeezed += b.size();
    if (b.size() >= kLongPayload_bytes) counted.of_long += b.size();
  }
  template <class T>
  void number(T) {
    counted.squeezed += sizeof(T);
  }
};

}  // namespace

template <class Sink>
bool Squeezer::walk(Sink sink, std::size_t full) {
  while (at_ < plain_.size() && sink.size() < full) {
    RecordLayout r;
    std::span<const std::byte> payload;
    if (kept_ > 0) {
      const std::size_t n = std::min(kept_, full - sink.size());
      sink.bytes(plain_.subspan(at_, n));
      at_ += n;
      kept_ -= n;
    } else if (record_at(plain_.subspan(at_), r, payload)) {
      if (r.index != next_) {
        sink.number(kIndex);
        sink.number(r.index);
      }
      sink.number(kRecord);
      sink.number(r.kind);
      sink.number(r.length);
      sink.bytes(payload);
      next_ = r.index + 1;
      at_ += sizeof r + padded(r.length);
    } else {
      kept_ =
          std::min<std::size_t>(find_record(plain_, at_) - at_, std::numeric_limits<std::uint32_t>::max());
      sink.number(kBytes);
      sink.number(std::uint32_t(kept_));
    }
  }
  return at_ < plain_.size();
}

bool Squeezer::more(std::vector<std::byte>& out, std::size_t bytes) {
  return walk(Appending{out}, bytes < out.max_size() - out.size() ? out.size() + bytes : out.max_size());
}

bool Squeezer::count(Counted& counted, std::size_t bytes) {
  return walk(Counting{counted}, counted.squeezed + bytes);
}

namespace {

// Bytes of the item that `begin` is the beginning of; while its head is not there yet, as many as are needed
// to know more.
std::size_t item_bytes(std::span<const std::byte> begin) {
  if (begin.empty()) return 1;
  const auto item = number_at<std::uint8_t>(begin, 0);
  if (item == kIndex) return kIndexBytes;
  if (item == kBytes) return kBytesHead;
  if (begin.size() < kRecordHead) return kRecordHead;
  return kRecordHead + number_at<std::uint32_t>(begin, 3);
}

}  // namespace

bool Restorer::take_item(std::span<const std::byte> item, std::vector<std::byte>& plain) {
  switch (number_at<std::uint8_t>(item, 0)) {
    case kBytes:
      kept_ = number_at<std::uint32_t>(item, 1);
      return true;
    case kIndex:
      next_ = number_at<std::uint64_t>(item, 1);
      return true;
    case kRecord: {
      const auto payload = item.subspan(kRecordHead);
      const RecordLayout r = layout_of(number_at<std::uint16_t>(item, 1), next_++, payload);
      append(plain, std::as_bytes(std::span(&r, 1)));
      append(plain, payload);
      plain.resize(plain.size() + padded(payload.size()) - payload.size());
      return true;
    }
    default:
      return false;
  }
}

bool Restorer::add(std::span<const std::byte> squeezed, std::vector<std::byte>& plain) {
  while (!squeezed.empty()) {
    std::size_t n = 0;
    if (kept_ > 0) {
      n = std::size_t(std::min<std::uint64_t>(kept_, squeezed.size()));
      append(plain, squeezed.first(n));
      kept_ -= n;
    } else if (item_.empty() && number_at<std::uint8_t>(squeezed, 0) > kIndex) {
      return false;
    } else if (n = item_bytes(squeezed); item_.empty() && n <= squeezed.size() &&
                                         item_bytes(squeezed.first(n)) == n) {  // whole, as most are
      if (!take_item(squeezed.first(n), plain)) return false;
    } else {
      n = std::min(item_bytes(item_) - item_.size(), squeezed.size());
      append(item_, squeezed.first(n));
      if (item_.size() == item_bytes(item_)) {
        if (!take_item(item_, plain)) return false;
        item_.clear();
      }
    }
    squeezed = squeezed.subspan(n);
  }
  return true;
}

std::vector<std::byte> squeeze_records(std::span<const std::byte> plain) {
  std::vector<std::byte> out;
  out.reserve(plain.size());
  Squeezer(plain).more(out, out.max_size());
  return out;
}

bool restore_records(std::span<const std::byte> squeezed, std::span<std::byte> plain) {
  std::vector<std::byte> restored;
  Restorer restorer;
  if (!restorer.add(squeezed, restored) || !restorer.whole() || restored.size() != plain.size()) return false;
  std::ranges::copy(restored, plain.begin());
  return true;
}

}  // namespace firn::record
