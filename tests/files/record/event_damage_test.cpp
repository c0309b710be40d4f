// The event log reader under damage, with the index and without: every byte of a small log, random places of
// a large one.
#include <catch2/catch.hpp>

#include <cstring>
#include <set>

#include "tests/files/record/event_samples.h"

using namespace firn;
using namespace firn::record;
using namespace firn::test;

namespace {

struct Original {
  std::vector<Sample> samples;
  Bytes log;
  record::EventIndex index;
  std::vector<std::uint64_t> at;  // offset of each event, and the end

  Original(std::size_t n, std::size_t longest, std::uint64_t seed, std::size_t fixed = 0)
      : samples(some_events(n, longest, seed, fixed)) {
    const Scratch scratch("event-damage");
    write_events(scratch / "log.lcm", samples);
    log = read_bytes(scratch / "log.lcm");
    index = record::EventIndex(read_bytes(scratch / "log.lcm.idx"));
    for (std::size_t e = 0; e < index.entries().size(); ++e) at.push_back(index.entries()[e].offset);
    at.push_back(log.size());
  }
  std::size_t touched(std::uint64_t from, std::uint64_t to) const {
    std::size_t n = 0;
    for (std::size_t i = 0; i + 1 < at.size(); ++i) n += at[i] < to && at[i + 1] > from;
    return n;
  }
};

struct EventOutcome {
  std::set<std::uint64_t> intact;  // numbers of events that came back byte for byte, not marked
  std::size_t marked = 0;
  std::size_t changed = 0;  // came back changed and not marked: only a reader without index may do this
  record::DamageList damage;
};

EventOutcome read_all(const Original& original, const Bytes& log, bool with_index) {
  EventOutcome o;
  record::EventLogReader reader(log, with_index ? &original.index : nullptr);
  while (const auto e = reader.next()) {
    if (e->damaged)
      ++o.marked;
    else if (e->eventnum < original.samples.size() && same(*e, original.samples[e->eventnum])) {
      if (!o.intact.insert(e->eventnum).second) FAIL("event " << e->eventnum << " came twice");
    } else
      ++o.changed;
  }
  o.damage = reader.damage();
  if (with_index && o.changed) FAIL(o.changed << " events came back changed and unmarked");
  return o;
}

bool reported_near(const EventOutcome& o, std::uint64_t at, std::uint64_t slack) {
  for (const record::Damage& d : o.damage.list())
    if (d.offset <= at + slack && at <= d.offset + d.bytes + slack) return true;
  return false;
}

}  // namespace

TEST_CASE("A bit flipped anywhere in a log costs at most its event, and with the index it is always found") {
  std::size_t trials = 0;
  for (const std::size_t fixed :
       {0u, 32u}) {  // equal sizes of 64 bytes: a wrong length may end on another sync word
    const Original original(24, 90, 21, fixed);
    for (std::size_t byte = 0; byte < original.log.size(); ++byte)
      for (int bit = 0; bit < 8; ++bit) {
        Bytes log = original.log;
        log[byte] ^= std::byte(1 << bit);
        ++trials;
        const EventOutcome with = read_all(original, log, true);
        if (with.intact.size() + 1 < 24)
          FAIL("byte " << byte << " bit " << bit << ": " << with.intact.size() << " left");
        if (!reported_near(with, byte, 0)) FAIL("byte " << byte << " bit " << bit << " not reported");
        const EventOutcome without = read_all(original, log, false);
        if (without.intact.size() + 2 < 24)
          FAIL("byte " << byte << " bit " << bit << ": " << without.intact.size() << " left without index");
      }
  }
  CHECK(trials >= 2 * 8 * 24 * 28);
}

TEST_CASE("With the index a damaged event header costs nothing") {
  const Original original(30, 90, 22);
  for (std::size_t i = 0; i < 30; ++i)
    for (std::size_t byte = 0; byte < record::kEventHeaderBytes; ++byte) {
      Bytes log = original.log;
      log[original.at[i] + byte] ^= std::byte{0x24};
      const EventOutcome o = read_all(original, log, true);
      if (o.intact.size() != 30) FAIL("event " << i << " byte " << byte << ": " << o.intact.size());
      REQUIRE(o.damage.list().at(0).offset == original.at[i]);
    }
}

TEST_CASE("A log cut anywhere keeps every event before the cut, and the index tells how many are gone") {
  std::size_t trials = 0;
  const Original original(30, 90, 23);
  for (std::size_t size = 0; size <= original.log.size(); ++size) {
    const Bytes log(original.log.begin(), original.log.begin() + std::ptrdiff_t(size));
    const auto whole =
        std::size_t(std::upper_bound(original.at.begin(), original.at.end(), size) - original.at.begin()) - 1;
    for (const bool with_index : {true, false}) {
      ++trials;
      const EventOutcome o = read_all(original, log, with_index);
      if (o.intact.size() != whole) FAIL("cut at " << size << ": " << o.intact.size() << " of " << whole);
      if (with_index && o.damage.lost() != 30 - whole)
        FAIL("cut at " << size << ": " << o.damage.lost() << " said lost");
      if (!with_index && (o.damage.count() > 0) != (original.at[whole] != size)) FAIL("cut at " << size);
    }
  }
  CHECK(trials == 2 * (original.log.size() + 1));
}

TEST_CASE("Bytes taken out of a log cost the events they touched and at most one neighbour") {
  std::size_t trials = 0;
  const Original original(40, 90, 24);
  for (std::size_t at = 0; at < original.log.size(); ++at)
    for (const std::size_t n : {1u, 4u, 64u, 333u})
      for (const bool with_index : {true, false}) {
        ++trials;
        const EventOutcome o = read_all(original, cut_from(original.log, at, n), with_index);
        const std::size_t lost = 40 - o.intact.size();
        if (lost > original.touched(at, at + n) + 1)
          FAIL("cut " << n << " at " << at << ": " << lost << " lost, index " << with_index);
        if (with_index && !reported_near(o, at, 130)) FAIL("cut " << n << " at " << at << " silent");
      }
  CHECK(trials == 4 * 2 * original.log.size());
}

TEST_CASE("A 4 KiB hole of zeros costs the events it touched and at most one neighbour") {
  std::size_t trials = 0;
  const Original original(3000, 200, 25);
  Random random{25};
  for (int trial = 0; trial < 200; ++trial) {
    const std::size_t at = random.below(original.log.size());
    for (const bool with_index : {true, false}) {
      ++trials;
      const EventOutcome o = read_all(original, with_zeros(original.log, at, 4096), with_index);
      const std::size_t lost = 3000 - o.intact.size();
      if (lost > original.touched(at, at + 4096) + (with_index ? 0 : 1))
        FAIL("hole at " << at << ": " << lost << " lost");
      if (!reported_near(o, at, 250)) FAIL("hole at " << at << " not reported");
    }
  }
  CHECK(trials == 2 * 200);
}

TEST_CASE("A repeated block is dropped and reported, and costs at most the event it split and a neighbour") {
  std::size_t trials = 0;
  for (const std::size_t fixed : {0u, 32u, 96u}) {
    const Original original(400, 120, 26, fixed);
    Random random{26 + fixed};
    for (int trial = 0; trial < 200; ++trial) {
      const std::size_t n = trial % 2 ? 4096 : 40 + random.below(8000);
      const std::size_t from = random.below(original.log.size() - 40);
      const std::size_t at = random.below(original.log.size());
      for (const bool with_index : {true, false}) {
        ++trials;
        const EventOutcome o = read_all(original, with_copy(original.log, from, n, at), with_index);
        const std::size_t lost = 400 - o.intact.size();
        if (lost > 2)
          FAIL("block " << from << "+" << n << " at " << at << ": " << lost << " lost, index " << with_index);
        if (with_index && o.damage.count() == 0)
          FAIL("block " << from << "+" << n << " at " << at << " silent");
      }
    }
  }
  CHECK(trials == 3 * 2 * 200);
}

TEST_CASE("An absurd length costs its event at most") {
  const Original original(40, 0, 27, 36);
  for (std::size_t i = 0; i < 40; ++i)
    for (const std::size_t field : {20u, 24u})
      for (const std::uint32_t length : {0x7fffffffu, 0xffffffffu, 0x80000000u, 0u, 1u, 36u + 68u * 3u}) {
        Bytes log = original.log;
        record::put_big32(log.data() + original.at[i] + field, length);
        const EventOutcome with = read_all(original, log, true), without = read_all(original, log, false);
        if (with.intact.size() < 39)
          FAIL("event " << i << " length " << length << ": " << with.intact.size());
        if (without.intact.size() < 38)
          FAIL("event " << i << " length " << length << ": " << without.intact.size() << " without index");
        REQUIRE(with.damage.list().at(0).offset == original.at[i]);
      }
}

TEST_CASE("Damage at many random places costs no more than the events touched and their neighbours") {
  std::size_t trials = 0;
  const Original original(4000, 150, 28);
  Random random{28};
  for (int trial = 0; trial < 30; ++trial) {
    Bytes log = original.log;
    std::set<std::size_t> touched;
    for (int i = 0; i < 60; ++i) {
      const std::size_t byte = random.below(log.size());
      log[byte] = std::byte(random());
      touched.insert(
          std::size_t(std::upper_bound(original.at.begin(), original.at.end(), byte) - original.at.begin()));
    }
    ++trials;
    const EventOutcome with = read_all(original, log, true), without = read_all(original, log, false);
    if (4000 - with.intact.size() > touched.size())
      FAIL(4000 - with.intact.size() << " lost, touched " << touched.size());
    if (4000 - without.intact.size() > 2 * touched.size())
      FAIL(4000 - without.intact.size() << " lost without index");
  }
  CHECK(trials == 30);
}

TEST_CASE("A damaged index costs checks, never events") {
  const Original original(1500, 60, 29);
  const Scratch scratch("index-damage");
  write_events(scratch / "log.lcm", original.samples);
  const Bytes index = read_bytes(scratch / "log.lcm.idx");
  Random random{29};
  for (int trial = 0; trial < 200; ++trial) {
    Bytes bad = index;
    if (trial % 3 == 0)
      bad.resize(random.below(index.size()));
    else if (trial % 3 == 1)
      bad = with_zeros(index, random.below(index.size()), 4096);
    else
      bad[random.below(index.size())] ^= std::byte(1 << random.below(8));
    const record::EventIndex read(bad);
    record::EventLogReader reader(original.log, &read);
    std::size_t n = 0;
    while (const auto e = reader.next()) {
      if (e->damaged || !same(*e, original.samples[n])) FAIL("event " << n << " trial " << trial);
      ++n;
    }
    REQUIRE(n == 1500);
    REQUIRE(reader.damage().count() == 0);
  }
}

TEST_CASE("Hostile bytes made of sync words and headers are read in linear work and bounded memory") {
  const std::size_t n = 300000;
  Bytes log(n * 29, std::byte{'A'});
  for (std::size_t i = 0; i < n; ++i)  // each claims the whole rest of the file and an unusual number
    record::put_event_header(log.data() + i * 29, {0, 7 * i + 3, 0, 1, std::int32_t((n - i - 1) * 29)});
  record::EventLogReader reader(log);
  std::size_t events = 0;
  while (reader.next()) ++events;
  CHECK(events <= n);
  CHECK(reader.damage().list().size() <= record::DamageList::kKept);
}
