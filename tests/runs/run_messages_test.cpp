// The messages of a run are the same from its log as from its write-ahead files.
#include <catch2/catch.hpp>

#include "files/record/event_index.h"
#include "files/text_file.h"
#include "firn/height_map_t.hpp"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/pack.h"
#include "runs/read/run_messages.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

using namespace firn;
namespace fs = std::filesystem;

namespace {

fs::path printed_run(const fs::path& root) {
  const Experiment e = test::tiny_print("messages");
  const runs::RunFolder run = runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  o.note = [](const std::string&) {};
  REQUIRE(run_in_lab(full_product(), run, o).result.status == 0);
  return run.path();
}

// The channels of the nodes' own messages: the launcher's and the recorder's are in the log alone.
runs::RunMessages::Channels logged_channels() {
  runs::RunMessages::Channels names;
  for (const ChannelInfo& channel : channel_table())
    if (channel.logged && runs::sent_by_node(channel)) names.emplace(channel.name);
  return names;
}

void check_same(const runs::RunMessages& messages, const runs::RunReader& oracle) {
  std::size_t compared = 0;
  for (const std::string& channel : logged_channels()) {
    INFO(channel);
    const auto &ours = messages.on(channel), &all = oracle.on(channel);
    REQUIRE(ours.size() == all.size());
    CHECK(std::ranges::equal(ours, all, [](auto a, auto b) { return std::ranges::equal(a, b); }));
    compared += all.size();
  }
  CHECK(compared > 100);
  CHECK(messages.incarnations() == int(oracle.starts().size()));
}

}  // namespace

TEST_CASE(
    "the log of a run that is over gives every message that its write-ahead files give, packed or not") {
  const test::TempFolder place;
  const fs::path run = printed_run(place.path());
  {
    const runs::RunReader oracle(run);
    const runs::RunMessages messages(run, logged_channels());
    CHECK(messages.reads_log());
    check_same(messages, oracle);
  }
  runs::pack_run(run);
  const runs::RunReader oracle(run);
  const runs::RunMessages packed(run, logged_channels());
  CHECK(packed.reads_log());
  check_same(packed, oracle);
  std::size_t decoded = 0;
  packed.each<height_map_t>("HEIGHT_MAP", [&](const height_map_t& m) { decoded += m.height_mm.size() > 0; });
  CHECK(decoded == oracle.on("HEIGHT_MAP").size());
}

TEST_CASE("a log that cannot stand for the write-ahead files is passed over for these") {
  const test::TempFolder place;
  const fs::path run = printed_run(place.path());
  fs::resize_file(run / "log.lcm", fs::file_size(run / "log.lcm") - 1);
  const runs::RunMessages messages(run, logged_channels());
  CHECK_FALSE(messages.reads_log());
  check_same(messages, runs::RunReader(run));
}

TEST_CASE("a channel that nobody asked for is no empty one") {
  const test::TempFolder place;
  const fs::path run = printed_run(place.path());
  const runs::RunMessages messages(run, {"HEIGHT_MAP"});
  CHECK_THROWS_AS(messages.on("LAYER_PLAN"), std::logic_error);
}

TEST_CASE("an index is handed over entry after entry, and not where its blocks or their order are damaged") {
  const test::TempFolder place;
  const fs::path file = printed_run(place.path()) / "log.lcm.idx";
  const record::MappedFile mapped(file);
  const record::EventIndex whole(mapped.bytes());
  std::size_t n = 0;
  CHECK(record::each_entry(mapped, [&](const record::IndexEntry& e, std::string_view channel) {
    CHECK(e.eventnum == whole.entries()[n].eventnum);
    CHECK(channel == whole.channel(e.channel));
    ++n;
    return true;
  }));
  CHECK(n == whole.entries().size());
  CHECK_FALSE(record::each_entry(mapped, [](auto...) { return false; }));
  std::string bytes = read_file(file);
  bytes[bytes.size() / 2] ^= 4;
  write_file_atomically(place.path() / "damaged", bytes);
  const record::MappedFile damaged(place.path() / "damaged");
  CHECK_FALSE(record::each_entry(damaged, [](auto...) { return true; }));
}
