// Schema::check against lcm-gen's decoders: the decoders read every message that the check passes. The check
// refuses messages that the decoders cannot hold, without allocating the sizes that the bytes claim.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "lcmtypes/schema.h"
#include "tests/lcmtypes/allocations.h"
#include "tests/lcmtypes/samples.h"

using namespace firn;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

const schema::Type& bounded_type(std::string_view name) { return *Schema::builtin().find(name); }

void put32(std::vector<std::byte>& bytes, std::size_t at, std::uint32_t v) {
  for (int i = 0; i < 4; ++i) bytes[at + std::size_t(i)] = std::byte(v >> (24 - 8 * i));
}

// check() says yes exactly when the decoder takes all bytes and encoding again gives them back.
template <class M>
void agree(const std::vector<std::byte>& bytes) {
  const auto error = check(bounded_type(M::getTypeName()), bytes);
  if (error) return;
  M m;
  const int used = m.decode(bytes.data(), 0, int(bytes.size()));
  if (used != int(bytes.size())) FAIL(M::getTypeName() << " decoded " << used << " of " << bytes.size());
  if (encode(m) != bytes) FAIL(M::getTypeName() << " does not encode back");
}

template <class M>
void try_damaged(const M& message) {
  const auto whole = encode(message);
  const schema::Type& t = bounded_type(M::getTypeName());
  REQUIRE_FALSE(check(t, whole));
  for (std::size_t size = 0; size < whole.size(); ++size) REQUIRE(check(t, std::span(whole).first(size)));
  auto longer = whole;
  longer.push_back(std::byte{0});
  const auto error = check(t, longer);
  REQUIRE(error);
  REQUIRE(error->offset == whole.size());
  for (std::size_t byte = 0; byte < std::min<std::size_t>(whole.size(), 400); ++byte)
    for (const int flip : {0x01, 0x80, 0xff}) {
      auto bytes = whole;
      bytes[byte] ^= std::byte(flip);
      agree<M>(bytes);
      if (byte < 8) REQUIRE(check(t, bytes));
    }
}

}  // namespace

TEST_CASE("Messages cut anywhere, lengthened or flipped are refused or decode to the same bytes") {
  try_damaged(some_height_map(5, 4));
  try_damaged(some_layer_plan(5, 4));
  try_damaged(some_pass(3, 3));
  try_damaged(some_heartbeat());
  try_damaged(some_header());
  tile_t tile{};
  tile.size = 5;
  tile.data = {1, 2, 3, 4, 5};
  try_damaged(tile);
}

TEST_CASE(
    "Absurd array sizes and string lengths are refused at their byte, without allocating what they claim") {
  const auto whole = encode(some_layer_plan(5, 4));
  REQUIRE_FALSE(
      check(bounded_type("layer_plan_t"), whole));  // the first use parses the schema, which allocates
  const std::size_t n_at = 8 + 28;                  // fingerprint, header
  const std::size_t reason_at = n_at + 4 + 4 + 4 + 8 + 1 + 4 + 40 + 4 + 4 + 8 + 8 + 8;
  for (const std::uint32_t v : {0x7fffffffu, 0xffffffffu, 0x80000000u, 0x40000000u, 100000u}) {
    auto bytes = whole;
    put32(bytes, n_at, v);
    largest_allocation() = 0;
    auto error = check(bounded_type("layer_plan_t"), bytes);
    CHECK(largest_allocation() < 1000);
    REQUIRE(error);
    CHECK(error->path == "drops");
    CHECK_THAT(error->message, Contains("array size n = " + std::to_string(std::int32_t(v))));
    CHECK(error->offset == whole.size() - 20);

    bytes = whole;
    put32(bytes, reason_at, v);
    error = check(bounded_type("layer_plan_t"), bytes);
    REQUIRE(error);
    CHECK(error->path == "reason");
    CHECK(error->offset == reason_at);
    CHECK_THAT(error->message, Contains("string length " + std::to_string(std::int32_t(v))));
  }
  auto bytes = whole;
  put32(bytes, reason_at, 0);  // LCM's decoder would make a string of length -1
  CHECK(check(bounded_type("layer_plan_t"), bytes));
}

TEST_CASE("A string with a zero byte inside is refused: LCM's encoder would cut it there") {
  auto bytes = encode(some_heartbeat());
  const auto at = std::search(bytes.begin(), bytes.end(), reinterpret_cast<const std::byte*>("STATE_JET"),
                              reinterpret_cast<const std::byte*>("STATE_JET") + 9);
  REQUIRE(at != bytes.end());
  at[2] = std::byte{0};
  const auto error = check(bounded_type("heartbeat_t"), bytes);
  REQUIRE(error);
  CHECK(error->path == "channel[1]");
  CHECK(error->offset == std::size_t(at - bytes.begin()) + 2);
}

TEST_CASE("A large dimension beside a zero one is refused: the decoder would allocate it") {
  const Schema s = Schema::parse("struct q_t { int32_t n; int32_t m; double v[n][m]; }");
  const schema::Type& q = *s.find("q_t");
  std::vector<std::byte> bytes(16);
  for (int i = 0; i < 8; ++i) bytes[std::size_t(i)] = std::byte(std::uint64_t(q.fingerprint) >> (56 - 8 * i));
  put32(bytes, 8, 0x7fffffff);
  CHECK_THAT(check(q, bytes)->message, Contains("n = 2147483647"));
  put32(bytes, 8, 5);
  CHECK_FALSE(check(q, bytes));
}

TEST_CASE("Checking a message allocates nothing") {
  const auto bytes = encode(some_height_map(40, 40));
  const schema::Type& t = bounded_type("height_map_t");
  largest_allocation() = 0;
  const bool ok = !check(t, bytes);
  const std::size_t allocated = largest_allocation();
  CHECK(ok);
  CHECK(allocated == 0);
}
