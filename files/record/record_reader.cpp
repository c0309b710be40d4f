#include "files/record/record_layout.h"

#include <string.h>  // memmem

#include <algorithm>

namespace firn::record {

struct RecordReader::Header : RecordLayout {
  std::uint64_t at;
  bool sync_ok, check_ok;
  std::uint64_t end() const { return at + kRecordHeaderBytes + padded(length); }
};

RecordReader::RecordReader(std::span<const std::byte> file) : file_(file) {
  if (file.empty()) return;
  const std::size_t n = std::min(file.size(), kFileHeader.size());
  header_ok_ = n == kFileHeader.size() && std::memcmp(file.data(), kFileHeader.data(), n) == 0;
  if (header_ok_)
    valid_end_ = at_ = kRecordFileHeaderBytes;
  else if (const auto h = header_at(kRecordFileHeaderBytes); h && h->sync_ok && h->check_ok) {
    damage_.add({0, kRecordFileHeaderBytes, "file header is damaged", 0});
    at_ = kRecordFileHeaderBytes;
  }
}

RecordReader::RecordReader(std::span<const std::byte> file, std::uint64_t from, std::uint64_t index)
    : RecordReader(file) {
  if (from <= valid_end_ || from > file.size()) return;
  at_ = valid_end_ = from;
  expected_ = valid_next_index_ = index;
}

// Returns the header at `at`, if a whole record of the stated length fits there.
std::optional<RecordReader::Header> RecordReader::header_at(std::uint64_t at) const {
  if (at > file_.size() || file_.size() - at < kRecordHeaderBytes) return {};
  Header h;
  std::memcpy(static_cast<RecordLayout*>(&h), file_.data() + at, kRecordHeaderBytes);
  if (h.length > kMaxRecordPayloadBytes || padded(h.length) > file_.size() - at - kRecordHeaderBytes)
    return {};
  h.at = at;
  h.sync_ok = h.sync == kSyncMarker;
  h.check_ok = h.check == h.expected_check();
  return h;
}

// Hashing long false candidates would be quadratic on hostile input: beyond a few times the file's size only
// short ones are still tried.
bool RecordReader::may_spend(std::uint64_t bytes) {
  return bytes <= 1024 || spent_in_vain_ <= 4 * file_.size();
}

bool RecordReader::checksum_holds(const Header& h) {
  if (!may_spend(h.length)) return false;
  const auto payload = file_.subspan(h.at + kRecordHeaderBytes, h.length);
  const bool holds = checksum64(h.covered(), {&payload, 1}) == h.checksum;
  if (!holds) spent_in_vain_ += h.length;
  return holds;
}

// Returns true if only this record is damaged, with the neighbour at the expected place.
bool RecordReader::framing_holds(const Header& h) {
  const std::uint64_t index = h.check_ok ? h.index : expected_;
  if (h.end() < file_.size()) {
    const auto next = header_at(h.end());
    return next && next->sync_ok && next->check_ok && next->index == index + 1;
  }
  // The last record: its length must not swallow others.
  if (h.index != index || !h.sync_ok || !may_spend(h.length)) return false;
  spent_in_vain_ += h.length;
  return !::memmem(file_.data() + h.at + 8, h.end() - h.at - 8, kSyncMarker.data(), kSyncMarker.size());
}

// Returns the next place from `from` on with valid marker, header and checksum; the file's size without one.
std::uint64_t RecordReader::resync(std::uint64_t from) {
  while (from < file_.size()) {
    const void* found =
        ::memmem(file_.data() + from, file_.size() - from, kSyncMarker.data(), kSyncMarker.size());
    if (!found) break;
    const std::uint64_t at = std::uint64_t(static_cast<const std::byte*>(found) - file_.data());
    if (const auto h = header_at(at); h && h->check_ok && checksum_holds(*h)) return at;
    from = at + kSyncMarker.size();
  }
  return file_.size();
}

// A record ahead of its turn is a copy of a later block if any record before its turn still follows.
bool RecordReader::is_stray(std::uint64_t index, std::uint64_t at) {
  if (index <= expected_) return false;
  if (!places_.built()) {
    for (std::uint64_t p = at; p < file_.size();) {
      const auto h = header_at(p);
      if (h && h->sync_ok && h->check_ok && checksum_holds(*h)) {
        places_.add(h->index, p);
        p = h->end();
      } else {
        p = resync(p + 1);
      }
    }
    places_.finish();
  }
  return places_.any_behind(expected_, index, at);
}

Record RecordReader::accept(const Header& h, std::uint64_t index, bool damaged) {
  expected_ = index + 1;
  at_ = h.end();
  if (!damaged) {
    valid_end_ = at_;
    valid_next_index_ = expected_;
  }
  return {index, h.kind, h.at, file_.subspan(h.at + kRecordHeaderBytes, h.length), damaged};
}

std::optional<Record> RecordReader::next() {
  while (at_ < file_.size()) {
    const auto h = header_at(at_);
    const bool in_place = h && (h->sync_ok || (h->check_ok && h->index == expected_));
    const bool whole = in_place && checksum_holds(*h);
    if (whole || (h && framing_holds(*h))) {
      const std::uint64_t index = whole || h->check_ok ? h->index : expected_;
      const std::uint64_t bytes = h->end() - h->at;
      if (index < expected_ || is_stray(index, h->at)) {
        damage_.add({h->at, bytes, "repeated record, dropped", 0});
        at_ = h->end();
        continue;
      }
      if (index > expected_)
        damage_.add({h->at, 0, "records are missing before this byte", index - expected_});
      if (!whole)
        damage_.add({h->at, bytes, h->check_ok ? "checksum does not hold" : "record header is damaged", 0});
      else if (!h->sync_ok)
        damage_.add({h->at, kSyncMarker.size(), "sync marker is damaged", 0});
      else if (const auto pad =
                   file_.subspan(h->at + kRecordHeaderBytes + h->length, padded(h->length) - h->length);
               std::any_of(pad.begin(), pad.end(), [](std::byte b) { return b != std::byte{0}; }))
        damage_.add({h->end() - pad.size(), pad.size(), "padding is not zero", 0});
      return accept(*h, index, !whole);
    }
    const std::uint64_t next = resync(at_ + 1);
    if (next == file_.size()) {
      damage_.add({at_, next - at_, h ? "record is damaged" : "record is cut or overwritten", 1});
    } else {
      const std::uint64_t index = header_at(next)->index;
      const bool gap = index > expected_ && !is_stray(index, next);
      damage_.add({at_, next - at_, "record is damaged", gap ? index - expected_ : 0});
      if (gap) expected_ = index;
    }
    at_ = next;
  }
  return {};
}

}  // namespace firn::record
