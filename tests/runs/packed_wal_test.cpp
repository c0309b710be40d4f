// Packed write-ahead files, as replay and audit read them.
#include <catch2/catch.hpp>

#include <fstream>

#include "core/grid/random.h"
#include "files/record/checksum.h"
#include "files/record/packed.h"
#include "files/record/record_file.h"
#include "runs/folder/recorded_steps.h"
#include "tests/replay/tiny_run.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using runs::WalFile;

TEST_CASE("The head of a node's file is read from its first records alone, plain or packed") {
  const fs::path folder = scratch_folder("parts-first-head");
  fs::create_directories(folder);
  const fs::path path = folder / "stage.wal";
  WalHead head{"stage", 7, 2, "commit", "platform", std::string(300'000, 'c'), "types", {{"target", "sha"}}};
  std::vector<std::byte> payload;
  encode_head(head, payload);
  {
    record::RecordWriter writer(path, record::File::Mode::kCreate);
    writer.append(std::uint16_t(WalKind::kHead), payload);
    RandomStream random(6, Purpose::kTest);
    payload.resize(1'000'000);
    for (std::byte& b : payload) b = std::byte(random.below(256));
    for (int n = 0; n < 4; ++n) writer.append(std::uint16_t(WalKind::kOutputs), payload);
    writer.close();
  }
  const auto check = [&] {
    const auto first = runs::first_head(path);
    REQUIRE(first);
    CHECK(first->node == head.node);
    CHECK(first->run_id == head.run_id);
    CHECK(first->incarnation == head.incarnation);
    CHECK(first->config_toml == head.config_toml);
    CHECK(first->blobs == head.blobs);
  };
  check();
  const std::vector<std::byte> plain = [&] {
    const record::MappedFile file(path);
    return std::vector<std::byte>(file.bytes().begin(), file.bytes().end());
  }();
  const auto write = [&](std::span<const std::byte> bytes) {
    fs::remove(path);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  };
  write(record::pack(plain, {}, ""));
  check();
  std::vector<std::byte> damaged = plain;
  damaged[1000] ^= std::byte(4);
  write(damaged);
  CHECK_FALSE(runs::first_head(path));
  write(record::pack(damaged, {}, ""));
  CHECK_FALSE(runs::first_head(path));
}

TEST_CASE("A packed node's file of any length has the steps of the plain one, and views of them stay valid") {
  const fs::path folder = scratch_folder("parts-packed");
  fs::create_directories(folder);
  const fs::path path = folder / "long.wal";
  RandomStream random(5, Purpose::kTest);
  std::vector<std::byte> bytes(8192), payload;
  {
    record::RecordWriter writer(path, record::File::Mode::kCreate, 1 << 20);
    for (std::uint64_t step = 1; step <= 9000; ++step) {  // 74 MB
      for (int n = 0; n < 16; ++n) bytes[random.below(8192)] = std::byte(random.below(256));
      Event e;
      e.kind = EventKind::kIo;
      e.id = 1;
      e.bytes = bytes;
      payload.clear();
      encode_event(step, e, payload);
      writer.append(std::uint16_t(WalKind::kEvent), payload);
    }
    writer.close();
  }
  const auto steps_of = [&] {
    WalFile file(path);
    std::vector<std::uint64_t> digests;
    std::vector<std::span<const std::byte>> views;
    for (WalFile::Item item = file.next(); item != WalFile::Item::kEnd; item = file.next()) {
      REQUIRE(item == WalFile::Item::kStep);
      views.push_back(file.step().event.bytes);
    }
    CHECK(file.damage().list().empty());
    for (const auto& view : views) digests.push_back(record::checksum64(view));
    return digests;
  };
  const std::vector<std::uint64_t> plain = steps_of();
  REQUIRE(plain.size() == 9000);
  const std::vector<std::byte> packed = [&] {
    const record::MappedFile file(path);
    return record::pack(file.bytes(), {}, "");
  }();
  fs::remove(path);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(packed.data()), std::streamsize(packed.size()));
  CHECK((steps_of() == plain));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace firn::test
