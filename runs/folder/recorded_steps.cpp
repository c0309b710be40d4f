#include "runs/folder/recorded_steps.h"

#include <functional>
#include <vector>

#include "files/record/packed.h"
#include "files/record/pages.h"

namespace firn::runs {

namespace {

bool is(const std::optional<record::Record>& record, WalKind kind) {
  return record && record->kind == std::uint16_t(kind);
}

constexpr std::size_t kLongestHead_bytes = std::size_t(16)
                                           << 20;  // it has a configuration and types of messages

std::optional<WalHead> head_of(std::span<const std::byte> begin) try {
  const auto first = record::RecordReader(begin).next();
  if (!first || first->damaged || WalKind(first->kind) != WalKind::kHead) return std::nullopt;
  return decode_head(first->payload);
} catch (const std::runtime_error&) {
  return std::nullopt;
}

}  // namespace

WalFile::WalFile(const std::filesystem::path& path) : map_(path), reader_(map_.bytes()) {}

std::optional<record::Record> WalFile::take() {
  std::optional<record::Record> record = ahead_ ? ahead_ : reader_.next();
  ahead_.reset();
  return record;
}

// Outputs follow their event directly; the next record shows if the incarnation ended here.
void WalFile::attach_outputs() {
  ahead_ = reader_.next();
  if (is(ahead_, WalKind::kOutputs)) {
    try {
      const WalOutputs outputs = decode_outputs(ahead_->payload);
      if (outputs.step == step_.step) {
        step_.has_outputs = true;
        step_.outputs = outputs.body;
        step_.handler_ns = outputs.handler_ns;
        if (ahead_->damaged) step_.damaged_at = ahead_->offset;
        ahead_ = reader_.next();
      }
    } catch (const std::runtime_error&) {
      // next() reads the record again and reports it
    }
  }
  step_.last = !ahead_ || is(ahead_, WalKind::kHead);
}

WalFile::Item WalFile::next() {
  const std::optional<record::Record> record = take();
  if (!record) return Item::kEnd;
  offset_ = record->offset;
  map_.forget_before(offset_);
  try {
    switch (WalKind(record->kind)) {
      case WalKind::kHead:
        head_ = decode_head(record->payload);
        return Item::kHead;
      case WalKind::kEvent: {
        const WalEvent event = decode_event(record->payload);
        step_ = RecordedStep{};
        step_.step = event.step;
        step_.event = event.event;
        if (record->damaged) step_.damaged_at = record->offset;
        step_.offset = record->offset;
        attach_outputs();
        return Item::kStep;
      }
      case WalKind::kOutputs: {
        const WalOutputs outputs = decode_outputs(record->payload);
        step_ = RecordedStep{};
        step_.step = outputs.step;
        step_.has_outputs = true;
        step_.outputs = outputs.body;
        if (record->damaged) step_.damaged_at = record->offset;
        step_.offset = record->offset;
        return Item::kStray;
      }
    }
    trouble_ = "record kind " + std::to_string(record->kind) + " is not known";
  } catch (const std::runtime_error& e) {
    trouble_ = e.what();
  }
  return Item::kUnknown;
}

// A page of a short message brings its neighbours: pages are given back by places, not by bytes read.
void WalFile::read_again(std::span<const std::byte> bytes) const {
  constexpr std::uint64_t kHeld_bytes = std::uint64_t(2) << 20;
  const std::span<const std::byte> all = map_.bytes();
  const std::less<const std::byte*> before;
  if (!map_.of_file() || before(bytes.data(), all.data()) || !before(bytes.data(), all.data() + all.size()))
    return;
  const auto at = std::uint64_t(bytes.data() - all.data());
  if (at >= again_from_ && at < again_from_ + kHeld_bytes) return;
  if (at > again_from_) record::forget_pages(all, again_from_, at);
  again_from_ = at;
}

std::optional<WalHead> first_head(const std::filesystem::path& path) {
  const record::MappedFile stored(path, record::MappedFile::Packed::kAsIs);
  if (!record::is_packed(stored.bytes())) return head_of(stored.bytes());
  record::PackedReader packed(path, stored.bytes());
  std::vector<std::byte> begin;
  std::size_t look = 0;  // at twice as many bytes each time
  for (auto part = packed.next(); !part.empty() && begin.size() < kLongestHead_bytes; part = packed.next()) {
    begin.insert(begin.end(), part.begin(), part.end());
    if (begin.size() < look) continue;
    if (auto head = head_of(begin)) return head;
    look = 2 * begin.size();
  }
  return head_of(begin);
}

}  // namespace firn::runs
