#include "files/record/repair.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <map>

#include "tests/files/record/event_samples.h"

using namespace firn::record;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

// A message whose data begin with incarnation and seq, as the caller's messages do.
struct Message {
  std::int64_t utime_us;
  std::string channel;
  record::MessageKey key;
  Bytes data;
};

std::vector<Message> some_messages(std::size_t n, std::uint64_t seed) {
  Random random{seed};
  std::map<std::string, std::uint64_t> seq;
  std::vector<Message> messages;
  std::int64_t utime_us = 0;
  for (std::size_t i = 0; i < n; ++i) {
    utime_us += std::int64_t(random.below(3));  // many at the same time
    const std::string channel = i % 3 ? "HEIGHT_PROFILE" : "ANSWER_JET";
    const record::MessageKey key{i > n / 2, ++seq[channel]};
    Bytes data(16 + random.below(50));
    std::memcpy(data.data(), &key, 16);
    messages.push_back({utime_us, channel, key, data});
  }
  return messages;
}

std::optional<record::MessageKey> key_of(std::string_view channel, std::span<const std::byte> data) {
  if (channel == "NOTE" || data.size() < 16) return {};
  record::MessageKey key;
  std::memcpy(&key, data.data(), 16);
  return key;
}

record::MessageSource all_of(const std::vector<Message>& messages) {
  return [&messages, i = std::size_t(0)]() mutable -> std::optional<record::SourceMessage> {
    if (i == messages.size()) return {};
    const Message& m = messages[i++];
    return record::SourceMessage{m.utime_us, m.channel, m.key, m.data};
  };
}

std::vector<record::Event> read(const record::EventLogFile& file) {
  std::vector<record::Event> events;
  record::EventLogReader reader = file.reader();
  while (const auto e = reader.next()) events.push_back(*e);
  CHECK(reader.damage().count() == 0);
  return events;
}

// In time order, per channel in key order, each message once and unchanged.
void expect_complete(const std::filesystem::path& log, const std::vector<Message>& messages,
                     std::size_t extra) {
  const record::EventLogFile file(log);
  const auto events = read(file);
  REQUIRE(events.size() == messages.size() + extra);
  std::map<std::string_view, record::MessageKey> last;
  std::map<std::pair<std::string_view, record::MessageKey>, const Message*> wanted;
  for (const Message& m : messages) wanted[{m.channel, m.key}] = &m;
  for (std::size_t i = 0; i < events.size(); ++i) {
    REQUIRE(events[i].checked);
    if (i) REQUIRE(events[i].utime_us >= events[i - 1].utime_us);
    const auto key = key_of(events[i].channel, events[i].data);
    if (!key) continue;
    REQUIRE(last[events[i].channel] < *key);
    last[events[i].channel] = *key;
    const auto it = wanted.find({events[i].channel, *key});
    REQUIRE(it != wanted.end());
    REQUIRE(std::ranges::equal(it->second->data, events[i].data));
    wanted.erase(it);
  }
  CHECK(wanted.empty());
}

}  // namespace

TEST_CASE("Missing messages are put back in time and channel order, whatever was lost") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scratch scratch("repair");
    const auto messages = some_messages(300, seed);
    Random random{seed};
    std::size_t lost = 0;
    {
      record::EventLogWriter writer(scratch / "log.lcm");
      for (const Message& m : messages) {
        if (random.below(4) == 0 && ++lost) continue;
        writer.append(m.utime_us, m.channel, m.data);
      }
      writer.append(messages.back().utime_us, "NOTE", as_span("kept as it is"));
      writer.close();
    }
    const record::RepairReport report = record::repair(scratch / "log.lcm", all_of(messages), key_of);
    CHECK(report.rewritten);
    CHECK(report.inserted == lost);
    CHECK(report.events == 301);
    CHECK(report.kept_path.empty());
    expect_complete(scratch / "log.lcm", messages, 1);

    const record::RepairReport again = record::repair(scratch / "log.lcm", all_of(messages), key_of);
    CHECK_FALSE(again.rewritten);
  }
}

TEST_CASE("The report gives count and times per channel") {
  const Scratch scratch("repair-report");
  std::vector<Message> messages;
  for (std::uint64_t i = 1; i <= 9; ++i) {
    Bytes data(16);
    const record::MessageKey key{0, i};
    std::memcpy(data.data(), &key, 16);
    messages.push_back({std::int64_t(i) * 100'000, "HEIGHT_PROFILE", key, data});
  }
  {
    record::EventLogWriter writer(scratch / "log.lcm");
    for (const Message& m : messages)
      if (m.key.low < 4 || m.key.low > 6) writer.append(m.utime_us, m.channel, m.data);
    writer.close();
  }
  const record::RepairReport report = record::repair(scratch / "log.lcm", all_of(messages), key_of);
  REQUIRE(report.gaps.size() == 1);
  CHECK(report.gaps[0].inserted == 3);
  CHECK(report.gaps[0].first_utime_us == 400'000);
  CHECK(report.gaps[0].last_utime_us == 600'000);
  CHECK(describe(report) ==
        std::vector<std::string>{
            "recording gap, repaired: 3 messages of HEIGHT_PROFILE between 0.400000 s and 0.600000 s"});
}

TEST_CASE("An inserted message never stands before its predecessor, though the recorder stamped that later") {
  const Scratch scratch("repair-order");
  const auto messages = some_messages(200, 5);
  {
    record::EventLogWriter writer(scratch / "log.lcm");
    for (std::size_t i = 0; i < messages.size(); ++i)
      if (i % 5) writer.append(messages[i].utime_us + 40, messages[i].channel, messages[i].data);
    writer.close();
  }
  CHECK(record::repair(scratch / "log.lcm", all_of(messages), key_of).inserted == 40);
  expect_complete(scratch / "log.lcm", messages, 0);
}

TEST_CASE(
    "Damaged events are replaced from a source, and what no source holds is left out and the old log kept") {
  const Scratch scratch("repair-damage");
  const auto messages = some_messages(300, 6);
  {
    record::EventLogWriter writer(scratch / "log.lcm");
    for (const Message& m : messages) writer.append(m.utime_us, m.channel, m.data);
    writer.append(messages.back().utime_us, "NOTE", as_span("a note that no write-ahead file holds"));
    writer.close();
  }
  Bytes log = read_bytes(scratch / "log.lcm");
  const Bytes before = log;
  Random random{6};
  for (int i = 0; i < 30; ++i) log[random.below(log.size())] ^= std::byte{0x40};
  log[log.size() - 3] ^= std::byte{1};
  write_file(scratch / "log.lcm", log);
  const record::RepairReport report = record::repair(scratch / "log.lcm", all_of(messages), key_of);
  CHECK(report.left_out >= 1);
  CHECK(report.inserted + report.replaced > 10);
  CHECK(report.damage.count() > 10);
  expect_complete(scratch / "log.lcm", messages, 0);
  CHECK(read_bytes(report.kept_path) == log);
  CHECK_THAT(describe(report).back(), Contains("left out; they stay in") && Contains("before-repair-1"));
}

TEST_CASE("A log without an index gets one, in order, without repeats") {
  const Scratch scratch("repair-index");
  const auto messages = some_messages(50, 7);
  {
    record::EventLogWriter writer(scratch / "log.lcm");
    for (const Message& m : messages)
      for (int copy = 0; copy < 2; ++copy) writer.append(m.utime_us, m.channel, m.data);
    writer.close();
  }
  std::filesystem::remove(scratch / "log.lcm.idx");
  const record::RepairReport report = record::repair(
      scratch / "log.lcm", [] { return std::optional<record::SourceMessage>(); }, key_of);
  CHECK(report.repeated == 50);
  expect_complete(scratch / "log.lcm", messages, 0);
}
