#include "runtime/cassette_deck.h"

#include <algorithm>
#include <cmath>

#include "files/text_file.h"

namespace firn {

CassetteDeck::CassetteDeck(const std::string& file) : CassetteDeck(parse_cassette(read_file(file), file)) {}

CassetteDeck::CassetteDeck(const Cassette& cassette) {
  using Kind = Cassette::Kind;
  double asked_ms = 0.0;
  for (const Cassette::Piece& p : cassette.pieces) {
    if (p.kind == Kind::kOrder) continue;
    if (p.kind == Kind::kSent || p.kind == Kind::kOpened) {
      tape_.push_back({p.kind == Kind::kOpened, p.bytes, {}});
      asked_ms = p.ms;
      continue;
    }
    if (tape_.empty()) tape_.push_back({true, {}, {}});
    tape_.back().answers.push_back({std::llround((p.ms - asked_ms) * 1e3), p.kind == Kind::kClosed, p.bytes});
  }
}

void CassetteDeck::answer(const Exchange& exchange, std::int64_t now_us) {
  for (const Answer& a : exchange.answers)
    due_.push_back({std::max(now_us + a.after_us, due_.empty() ? 0 : due_.back().at_us), &a});
}

void CassetteDeck::open(std::int64_t now_us) {
  due_.clear();
  for (std::size_t n = 0; n < tape_.size(); ++n) {
    const std::size_t k = (at_ + n) % tape_.size();
    if (!tape_[k].opening) continue;
    at_ = k + 1;
    return answer(tape_[k], now_us);
  }
}

bool CassetteDeck::send(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (std::size_t n = 0; n < tape_.size(); ++n) {
    const std::size_t k = (at_ + n) % tape_.size();
    if (tape_[k].opening || !std::ranges::equal(tape_[k].sent, bytes)) continue;
    at_ = k + 1;
    answer(tape_[k], now_us);
    return true;
  }
  return false;
}

bool CassetteDeck::take(std::int64_t now_us, std::vector<std::byte>& bytes, bool& closed) {
  if (due_us() > now_us) return false;
  const Answer& a = *due_.front().answer;
  due_.pop_front();
  bytes = a.bytes;
  closed = a.closes;
  if (closed) due_.clear();
  return true;
}

}  // namespace firn
