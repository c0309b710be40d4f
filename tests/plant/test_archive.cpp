#include <catch2/catch.hpp>

#include <array>
#include <cstring>
#include <new>

#include "plant/record/archive.h"

using namespace firn::plant;

namespace {

struct Padded {
  char kind = 'k';
  double value = 1.5;
  std::int32_t count = 7;
};

/// The state of a Padded in memory that held `rubbish` before.
std::vector<std::byte> saved(int rubbish) {
  alignas(Padded) std::array<std::byte, sizeof(Padded)> memory;
  std::memset(memory.data(), rubbish, memory.size());
  Archive a;
  a(*new (memory.data()) Padded);
  return a.bytes();
}

}  // namespace

TEST_CASE("Equal states are saved as equal bytes, whatever lay between their members") {
  CHECK(saved(0x00) == saved(0xff));
}

TEST_CASE("A loaded state is the saved one, and a cut one is refused") {
  Padded p{'x', 0.1, -3};
  std::vector<double> heights{1.0, 2.0};
  std::string text = "abc";
  Archive out;
  out.all(p, heights, text);
  Padded q;
  std::vector<double> loaded;
  std::string read;
  Archive in(out.bytes());
  in.all(q, loaded, read);
  in.expect_end();
  CHECK((q.kind == p.kind && q.value == p.value && q.count == p.count));
  CHECK(loaded == heights);
  CHECK(read == text);
  for (std::size_t n = 0; n < out.bytes().size(); ++n) {
    Archive cut({out.bytes().begin(), out.bytes().begin() + std::ptrdiff_t(n)});
    CHECK_THROWS_WITH(cut.all(q, loaded, read), Catch::Contains("cut short"));
  }
}

TEST_CASE("A loaded byte that is neither true nor false is refused by its place") {
  struct Switches {
    std::int32_t count = 3;
    std::array<bool, 2> relays{true, false};
    bool open = true;
    void io(Archive& a) { a.all(count, relays, open); }
  };
  Switches s;
  Archive out;
  out(s);
  REQUIRE(out.bytes().size() == 7);
  for (std::size_t n = 4; n < 7; ++n)
    for (const int value : {2, 0x80, 0xff}) {
      std::vector<std::byte> damaged = out.bytes();
      damaged[n] = std::byte(value);
      Archive in(damaged);
      CHECK_THROWS_WITH(in(s), Catch::Contains("neither true nor false at byte " + std::to_string(n)));
    }
}

TEST_CASE("A class with a bool is told from one without, so that none is loaded by its bytes") {
  struct With {
    double value = 0.0;
    std::array<int, 2> counts{};
    bool open = false;
  };
  constexpr auto fields = std::make_index_sequence<32>{};
  CHECK(has_bool<With>(fields));
  CHECK_FALSE(has_bool<Padded>(fields));
}
