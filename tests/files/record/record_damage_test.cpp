// The record reader under damage: every byte of a small file, random places of a large one.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstring>
#include <map>

#include "files/record/record_layout.h"
#include "tests/files/record/scratch.h"

using namespace firn::record;
using namespace firn::test;

namespace {

struct OriginalRecord {
  Bytes file;
  std::vector<Bytes> payloads;
  std::vector<std::uint64_t> at;  // offset of each record, and the end

  OriginalRecord(std::size_t records, std::size_t fixed, std::size_t longest, std::uint64_t seed) {
    const Scratch scratch("record-damage");
    Random random{seed};
    record::RecordWriter writer(scratch / "a.wal", record::RecordWriter::Mode::kCreate);
    for (std::size_t i = 0; i < records; ++i) {
      payloads.push_back(random_bytes(random, fixed ? fixed : random.below(longest)));
      at.push_back(writer.bytes());
      writer.append(std::uint16_t(i % 5), payloads.back());
    }
    at.push_back(writer.bytes());
    file = read_bytes(scratch / "a.wal");
  }
  // Records that [from, to) touches.
  std::size_t touched(std::uint64_t from, std::uint64_t to) const {
    std::size_t n = 0;
    for (std::size_t i = 0; i + 1 < at.size(); ++i) n += at[i] < to && at[i + 1] > from;
    return n;
  }
};

struct RecordOutcome {
  std::size_t intact = 0, flagged = 0;
  record::DamageList damage;
};

// Reads everything; each record that comes back undamaged must equal the record written under that index,
// byte for byte.
RecordOutcome read_records(const OriginalRecord& original, const Bytes& file) {
  RecordOutcome o;
  record::RecordReader reader(file);
  std::uint64_t last = 0;
  bool first = true;
  while (const auto r = reader.next()) {
    if (!first && r->index <= last) FAIL("index " << r->index << " after " << last);
    first = false;
    last = r->index;
    if (r->index >= original.payloads.size()) FAIL("index " << r->index << " was never written");
    if (r->damaged) {
      ++o.flagged;
      continue;
    }
    const Bytes& want = original.payloads[r->index];
    if (r->payload.size() != want.size() || !std::equal(want.begin(), want.end(), r->payload.begin()))
      FAIL("record " << r->index << " came back changed");
    ++o.intact;
  }
  o.damage = reader.damage();
  return o;
}

// Some damage is reported whose bytes reach to within one record of `at`.
bool record_reported_near(const OriginalRecord& original, const RecordOutcome& o, std::uint64_t at,
                          std::uint64_t longest) {
  return std::any_of(o.damage.list().begin(), o.damage.list().end(), [&](const record::Damage& d) {
    return d.offset <= at + longest && at <= d.offset + d.bytes + longest;
  });
}

}  // namespace

TEST_CASE("A bit flipped anywhere costs at most the record that holds it, and is reported there") {
  std::size_t trials = 0;
  for (const std::size_t fixed :
       {0u, 32u}) {  // equal sizes: a wrong length may end on another record's marker
    const OriginalRecord original(24, fixed, 90, 11);
    for (std::size_t byte = 0; byte < original.file.size(); ++byte)
      for (int bit = 0; bit < 8; ++bit) {
        Bytes file = original.file;
        file[byte] ^= std::byte(1 << bit);
        ++trials;
        const RecordOutcome o = read_records(original, file);
        if (o.intact + 1 < original.payloads.size())
          FAIL("byte " << byte << " bit " << bit << ": " << o.intact << " left");
        if (!record_reported_near(original, o, byte, 0))
          FAIL("byte " << byte << " bit " << bit << " not reported");
      }
  }
  CHECK(trials >= 2 * 8 * 24 * 40);
}

TEST_CASE("A payload bit flipped between whole neighbours is delivered and marked as damaged") {
  const OriginalRecord original(10, 0, 90, 12);
  for (std::size_t i = 0; i < original.payloads.size(); ++i)
    for (std::size_t byte = 0; byte < original.payloads[i].size(); ++byte) {
      Bytes file = original.file;
      file[original.at[i] + record::kRecordHeaderBytes + byte] ^= std::byte{0x10};
      const RecordOutcome o = read_records(original, file);
      if (o.flagged != 1 || o.intact != 9) FAIL("record " << i << " byte " << byte);
      REQUIRE(o.damage.list().at(0).offset == original.at[i]);
      REQUIRE(o.damage.lost() == 0);
    }
}

TEST_CASE("A file cut anywhere keeps every record before the cut") {
  std::size_t trials = 0;
  const OriginalRecord original(30, 0, 90, 13);
  for (std::size_t size = 0; size <= original.file.size(); ++size) {
    const Bytes file(original.file.begin(), original.file.begin() + std::ptrdiff_t(size));
    ++trials;
    const RecordOutcome o = read_records(original, file);
    const std::size_t whole = std::size_t(
        std::count_if(original.at.begin() + 1, original.at.end(), [&](auto end) { return end <= size; }));
    if (o.intact != whole) FAIL("cut at " << size << ": " << o.intact << " of " << whole);
    const bool torn = size > record::kRecordFileHeaderBytes
                          ? original.at[whole] != size
                          : size != 0 && size != record::kRecordFileHeaderBytes;
    if (torn != (o.damage.count() > 0)) FAIL("cut at " << size << " damage " << o.damage.count());
  }
  CHECK(trials == original.file.size() + 1);
}

TEST_CASE("Bytes taken out of the middle cost what they touched, at most one record more, and are reported") {
  std::size_t trials = 0;
  const OriginalRecord original(40, 0, 90, 14);
  for (std::size_t at = 0; at < original.file.size(); ++at)
    for (const std::size_t n : {1u, 8u, 64u, 333u}) {
      ++trials;
      const RecordOutcome o = read_records(original, cut_from(original.file, at, n));
      const std::size_t lost = original.payloads.size() - o.intact;
      if (lost > original.touched(at, at + n) + 1)
        FAIL("cut " << n << " at " << at << ": " << lost << " lost");
      if (lost > 0 && o.damage.count() == 0 && at + n < original.at.back())
        FAIL("cut " << n << " at " << at << " silent");
    }
  CHECK(trials == 4 * original.file.size());
}

TEST_CASE("A hole of zeros costs what it touched, and is reported") {
  std::size_t trials = 0;
  const OriginalRecord original(3000, 0, 200, 15);
  Random random{15};
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t at = random.below(original.file.size());
    ++trials;
    const RecordOutcome o = read_records(original, with_zeros(original.file, at, 4096));
    const std::size_t lost = original.payloads.size() - o.intact;
    if (lost > original.touched(at, at + 4096)) FAIL("hole at " << at << ": " << lost << " lost");
    if (!record_reported_near(original, o, at, 250)) FAIL("hole at " << at << " not reported");
  }
  CHECK(trials == 300);
}

TEST_CASE("A repeated block is dropped and reported, and costs at most the record it split") {
  std::size_t trials = 0;
  for (const std::size_t fixed : {0u, 32u, 96u}) {
    const OriginalRecord original(400, fixed, 120, 16);
    Random random{16 + fixed};
    for (int trial = 0; trial < 300; ++trial) {
      const std::size_t n = trial % 2 ? 4096 : 1 + random.below(8000);
      const std::size_t from = random.below(original.file.size() - 16);
      const std::size_t at = random.below(original.file.size());
      ++trials;
      const RecordOutcome o = read_records(original, with_copy(original.file, from, n, at));
      const std::size_t copied = std::min(n, original.file.size() - from);
      const std::size_t lost = original.payloads.size() - o.intact;
      if (lost > 2) FAIL("block " << from << "+" << copied << " at " << at << ": " << lost << " lost");
      if (o.damage.count() == 0) FAIL("block " << from << "+" << copied << " at " << at << " silent");
    }
  }
  CHECK(trials == 3 * 300);
}

TEST_CASE("An absurd length costs the record that claims it") {
  const OriginalRecord original(40, 48, 0, 17);
  for (std::size_t i = 0; i < original.payloads.size(); ++i)
    for (const std::uint32_t length : {0x7fffffffu, 0xffffffffu, 0x80000000u, 0u, 1u, 128u, 48u + 80u * 5u}) {
      Bytes file = original.file;
      std::memcpy(file.data() + original.at[i] + 12, &length, 4);
      const RecordOutcome o = read_records(original, file);
      if (o.intact + 1 < original.payloads.size())
        FAIL("record " << i << " length " << length << ": " << o.intact);
      REQUIRE(o.damage.list().at(0).offset == original.at[i]);
    }
}

TEST_CASE("Many damages at random places cost no more than the records they touch and their neighbours") {
  std::size_t trials = 0;
  const OriginalRecord original(5000, 0, 150, 18);
  Random random{18};
  for (int trial = 0; trial < 50; ++trial) {
    Bytes file = original.file;
    std::map<std::size_t, int> touched;
    for (int i = 0; i < 100; ++i) {
      const std::size_t byte =
          record::kRecordFileHeaderBytes + random.below(file.size() - record::kRecordFileHeaderBytes);
      file[byte] = std::byte(random());
      const auto record =
          std::upper_bound(original.at.begin(), original.at.end(), byte) - original.at.begin() - 1;
      ++touched[std::size_t(record)];
    }
    ++trials;
    const RecordOutcome o = read_records(original, file);
    const std::size_t lost = original.payloads.size() - o.intact;
    if (lost > touched.size() + 2) FAIL(lost << " lost, " << touched.size() << " touched");
  }
  CHECK(trials == 50);
}

TEST_CASE("Hostile bytes made of markers and headers are read in linear work and bounded memory") {
  // Headers whose own check holds and that each claim the whole rest of the file: hashing each would be
  // quadratic.
  const OriginalRecord one(2, 64, 0, 19);
  record::RecordLayout header;
  std::memcpy(&header, one.file.data() + one.at[1], sizeof header);
  Bytes file(one.file.begin(), one.file.begin() + std::ptrdiff_t(one.at[1]));
  const std::size_t n = 300000;
  for (std::size_t i = 0; i < n; ++i) {
    header.length = std::uint32_t((n - i - 1) * record::kRecordHeaderBytes);
    header.check = header.expected_check();
    const auto* bytes = reinterpret_cast<const std::byte*>(&header);
    file.insert(file.end(), bytes, bytes + sizeof header);
  }
  record::RecordReader reader(file);
  std::size_t records = 0;
  while (reader.next()) ++records;
  CHECK(records <= 2);
  CHECK(reader.damage().list().size() <= record::DamageList::kKept);
  CHECK(reader.damage().count() >= 1);
}
