#include <string.h>  // memmem

#include <algorithm>

#include "files/record/checksum.h"
#include "files/record/event_log.h"

namespace firn::record {

EventLogReader::EventLogReader(std::span<const std::byte> log, const EventIndex* index)
    : log_(log), index_(index) {
  if (index_ && !index_belongs()) {
    index_ = nullptr;
    index_ignored_ = true;
  }
  if (!index_) numbered_ = numbers_count();
}

// Half of the first events have the number that follows their neighbour's; one event alone tells nothing.
bool EventLogReader::numbers_count() const {
  EventHeader h, next;
  int pairs = 0, counted = 0;
  for (std::uint64_t at = 0; pairs < 64 && plausible_event(log_, at, h); at = h.end()) {
    if (!plausible_event(log_, h.end(), next)) break;
    ++pairs;
    counted += next.eventnum == h.eventnum + 1;
  }
  return pairs == 0 || 2 * counted >= pairs;
}

// An event is followed by a sync word or by the end.
std::optional<Event> EventLogReader::next_unnumbered() {
  EventHeader h;
  std::uint64_t at = at_;
  while (at < log_.size() && !(plausible_event(log_, at, h) && sync_follows(h))) {
    const void* found = ::memmem(log_.data() + at + 1, log_.size() - at - 1, kEventSyncBytes.data(), 4);
    at = found ? std::uint64_t(static_cast<const std::byte*>(found) - log_.data()) : log_.size();
  }
  if (at > at_) damage_.add({at_, at - at_, "event is damaged", 1});
  at_ = at;
  if (at == log_.size()) return {};
  return accept(h, expected_, false, false);
}

// An index of another log matches none of the first events.
bool EventLogReader::index_belongs() const {
  EventHeader h;
  int compared = 0;
  for (std::uint64_t at = 0; compared < 16 && plausible_event(log_, at, h); at = h.end())
    if (const IndexEntry* e = index_->find(h.eventnum)) {
      if (e->bytes == h.bytes() && e->checksum == checksum64(log_.subspan(at, h.bytes()))) return true;
      ++compared;
    }
  return compared < 4;
}

bool EventLogReader::certain(const EventHeader& h) {
  const IndexEntry* e = index_ ? index_->find(h.eventnum) : nullptr;
  if (!e || e->bytes != h.bytes() || !may_spend(h.bytes())) return false;
  const bool holds = checksum64(log_.subspan(h.at, h.bytes())) == e->checksum;
  if (!holds) spent_in_vain_ += h.bytes();
  return holds;
}

bool EventLogReader::successor_follows(const EventHeader& h) const {
  EventHeader next;
  return plausible_event(log_, h.end(), next) && next.eventnum == h.eventnum + 1;
}

// Returns true if the bytes behind the event begin like a sync word, or the log ends.
bool EventLogReader::sync_follows(const EventHeader& h) const {
  const std::size_t n = std::min<std::size_t>(4, log_.size() - h.end());
  return std::memcmp(log_.data() + h.end(), kEventSyncBytes.data(), n) == 0;
}

// Returns true if later events lie inside this one: the length is then wrong, or bytes are missing.
bool EventLogReader::swallows_events(const EventHeader& h) {
  if (!may_spend(h.bytes())) return true;
  spent_in_vain_ += h.bytes();
  EventHeader inner;
  for (std::uint64_t from = h.at + 4; from < h.end();) {
    const void* found = ::memmem(log_.data() + from, h.end() - from, kEventSyncBytes.data(), 4);
    if (!found) return false;
    from = std::uint64_t(static_cast<const std::byte*>(found) - log_.data());
    if (plausible_event(log_, from, inner) && inner.eventnum > h.eventnum &&
        (inner.eventnum == h.eventnum + 1 || inner.end() == log_.size() || successor_follows(inner)))
      return true;
    if (plausible_event(log_, from, inner) && starts_anew(inner)) return true;  // the next log of `cat`
    from += 4;
  }
  return false;
}

// Credibility of an event at its due place: confirmed by the neighbour, or else by the number without a
// contradiction.
bool EventLogReader::credible_in_place(const EventHeader& h) {
  if (successor_follows(h)) return true;
  EventHeader next;
  const bool bounded =
      h.end() == log_.size() || plausible_event(log_, h.end(), next) || h.eventnum == expected_;
  return bounded && !swallows_events(h);
}

bool EventLogReader::credible_after_damage(const EventHeader& h) {
  if (certain(h)) return true;
  if (const IndexEntry* e = index_ ? index_->find(h.eventnum) : nullptr; e && e->bytes != h.bytes())
    return false;
  if (successor_follows(h)) return true;
  const std::uint64_t room =
      (h.at - at_) / (kEventHeaderBytes + 1) + 1;  // events that the damage can have held
  const bool likely = h.eventnum <= expected_ + room || h.end() == log_.size();
  return h.eventnum >= expected_ && likely && !swallows_events(h);
}

// Returns the event that the index places here, for an event with an untrusted header.
std::optional<Event> EventLogReader::restored_by_index() {
  const IndexEntry* e = index_ ? index_->find(expected_) : nullptr;
  if (!e || std::int64_t(e->offset) + shift_ != std::int64_t(at_) || e->bytes > log_.size() - at_) return {};
  const std::string_view channel = index_->channel(e->channel);
  if (channel.empty() || e->bytes < kEventHeaderBytes + channel.size()) return {};
  EventHeader next;
  const std::uint64_t end = at_ + e->bytes;
  const bool neighbour =
      end == log_.size() || (plausible_event(log_, end, next) && next.eventnum == expected_ + 1);
  const EventHeader h{at_, expected_, e->utime_us, std::int32_t(channel.size()),
                      std::int32_t(e->bytes - kEventHeaderBytes - channel.size())};
  std::array<std::byte, kEventHeaderBytes> head;
  put_event_header(head.data(), h);
  const auto data = log_.subspan(end - std::uint64_t(h.data_bytes), std::uint64_t(h.data_bytes));
  const std::array<std::span<const std::byte>, 2> rest{std::as_bytes(std::span(channel)), data};
  const bool data_holds = checksum64(head, rest) == e->checksum;
  if (!neighbour && !data_holds) return {};
  damage_.add({at_, e->bytes,
               data_holds ? "event header is damaged, restored from the index" : "checksum does not hold",
               0});
  Event event = accept(h, expected_, !data_holds, data_holds);
  event.channel = channel;
  event.data = data;
  return event;
}

bool EventLogReader::is_stray(std::uint64_t eventnum, std::uint64_t at) {
  if (eventnum <= expected_) return false;
  if (!places_.built()) {
    EventHeader h;
    for (std::uint64_t p = at; p < log_.size();)
      if (plausible_event(log_, p, h) && (certain(h) || successor_follows(h) || h.end() == log_.size())) {
        if (starts_anew(h)) break;  // the numbers of another log
        places_.add(h.eventnum, p);
        p = h.end();
      } else {
        const void* found = ::memmem(log_.data() + p + 1, log_.size() - p - 1, kEventSyncBytes.data(), 4);
        p = found ? std::uint64_t(static_cast<const std::byte*>(found) - log_.data()) : log_.size();
      }
    places_.finish();
  }
  return places_.any_behind(expected_, eventnum, at);
}

// LCM's append mode and `cat a.log b.log` count from 0 again.
bool EventLogReader::starts_anew(const EventHeader& h) const {
  return h.eventnum == 0 && first_ && expected_ > 0 && successor_follows(h) &&
         (first_->bytes() != h.bytes() ||
          !std::ranges::equal(log_.subspan(first_->at, h.bytes()), log_.subspan(h.at, h.bytes())));
}

Event EventLogReader::accept(const EventHeader& h, std::uint64_t eventnum, bool damaged, bool checked) {
  if (!first_ && !damaged) first_ = h;
  expected_ = eventnum + 1;
  at_ = h.end();
  if (!damaged) {
    valid_end_ = at_;
    valid_next_ = expected_;
  }
  const auto data = log_.subspan(h.end() - std::uint64_t(h.data_bytes), std::uint64_t(h.data_bytes));
  return {eventnum, h.utime_us, event_channel(log_, h), data, h.at, damaged, checked};
}

// Returns the event at at_, if one is recognizable. Drops repeated ones.
std::optional<Event> EventLogReader::in_place() {
  EventHeader h, next;
  while (plausible_event(log_, at_, h)) {
    const bool sure = certain(h);
    if (!sure && starts_anew(h)) {
      index_ = nullptr;  // numbers no longer name one event
      places_ = {};
      ++restarts_;
      return accept(h, 0, false, false);
    }
    bool damaged = false;
    if (!sure) {
      if (auto restored = restored_by_index()) return restored;
      const IndexEntry* e = index_ ? index_->find(h.eventnum) : nullptr;
      if ((e && e->bytes != h.bytes()) || !credible_in_place(h)) return {};
      const bool bounded = plausible_event(log_, h.end(), next);
      if (bounded && h.eventnum != expected_ && next.eventnum == expected_ + 1) {
        damage_.add({at_, h.bytes(), "event number is wrong", 0});
        return accept(h, expected_, true, false);
      }
      damaged = e || !sync_follows(h);
    }
    if (h.eventnum < expected_ || is_stray(h.eventnum, at_)) {
      damage_.add({at_, h.bytes(), "repeated event, dropped", 0});
      at_ = h.end();
      continue;
    }
    if (h.eventnum > expected_)
      damage_.add({at_, 0, "events are missing before this byte", h.eventnum - expected_});
    if (damaged) damage_.add({at_, h.bytes(), "checksum does not hold, or no event follows", 0});
    if (sure) shift_ = std::int64_t(at_) - std::int64_t(index_->find(h.eventnum)->offset);
    return accept(h, h.eventnum, damaged, sure);
  }
  return at_ < log_.size() ? restored_by_index() : std::nullopt;
}

// Returns the next credible event from `from` on; the log's size without one.
std::uint64_t EventLogReader::find_credible(std::uint64_t from) {
  EventHeader h;
  while (from < log_.size()) {
    const void* found = ::memmem(log_.data() + from, log_.size() - from, kEventSyncBytes.data(), 4);
    if (!found) break;
    from = std::uint64_t(static_cast<const std::byte*>(found) - log_.data());
    if (plausible_event(log_, from, h) && credible_after_damage(h)) return from;
    from += 4;
  }
  return log_.size();
}

void EventLogReader::skip_damage() {
  const std::uint64_t next = find_credible(at_ + 1);
  EventHeader h;
  if (next == log_.size()) {
    const std::uint64_t known =
        index_ && !index_->entries().empty() ? index_->entries().back().eventnum + 1 : 0;
    damage_.add({at_, next - at_, "event is cut or overwritten",
                 std::max<std::uint64_t>(known, expected_ + 1) - expected_});
    expected_ = std::max(expected_ + 1, known);
  } else {
    plausible_event(log_, next, h);
    const bool gap = h.eventnum > expected_ && !is_stray(h.eventnum, next);
    damage_.add({at_, next - at_, "event is damaged", gap ? h.eventnum - expected_ : 0});
    if (gap) expected_ = h.eventnum;
  }
  at_ = next;
}

std::optional<Event> EventLogReader::next() {
  if (!numbered_) return next_unnumbered();
  while (at_ < log_.size()) {
    if (auto event = in_place()) return event;
    if (at_ < log_.size()) skip_damage();
  }
  const std::uint64_t known =
      index_ && !index_->entries().empty() ? index_->entries().back().eventnum + 1 : 0;
  if (known > expected_) {
    damage_.add({log_.size(), 0, "log is cut: the index knows more events", known - expected_});
    expected_ = known;
  }
  return {};
}

EventLogFile::EventLogFile(const std::filesystem::path& path) : log_(path) {
  if (!std::filesystem::exists(index_path(path))) return;
  const MappedFile file(index_path(path));
  index_ = EventIndex(file.bytes());
  has_index_ = true;
}

}  // namespace firn::record
