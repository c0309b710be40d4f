#include <catch2/catch.hpp>

#include <array>
#include <cstring>
#include <new>
#include <optional>

#include "plant/record/archive.h"
#include "plant/twins/motion.h"

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

TEST_CASE("Only numbers, enums and structures of nothing else are loaded by their bytes") {
  struct Flag {
    int count = 0;
    bool on = false;
  };
  struct Nested {
    double value = 0.0;
    Flag flag;
  };
  class Private {
   public:
    bool on() const { return on_; }

   private:
    bool on_ = false;
  };
  struct Poses {
    std::array<Padded, 2> poses{};
    std::array<int, 3> counts{};
    std::byte byte{};
  };
  STATIC_REQUIRE(is_plain<Padded>());
  STATIC_REQUIRE(is_plain<Poses>());
  STATIC_REQUIRE(is_plain<std::array<double, 4>>());
  STATIC_REQUIRE_FALSE(is_plain<bool>());
  STATIC_REQUIRE_FALSE(is_plain<Flag>());
  STATIC_REQUIRE_FALSE(is_plain<Nested>());
  STATIC_REQUIRE_FALSE(is_plain<std::array<Flag, 2>>());
  STATIC_REQUIRE_FALSE(is_plain<Private>());
  STATIC_REQUIRE_FALSE(is_plain<std::optional<int>>());
}

TEST_CASE("A loaded move is the saved one, and one of more phases than it holds is refused") {
  Move move = Move::trapezoid({0.0, 0.0, 0.0}, {3.0, 4.0, 0.0}, 20.0, 500.0, 7);
  Archive out;
  out(move);
  Move loaded;
  Archive in(out.bytes());
  in(loaded);
  in.expect_end();
  CHECK(loaded.end_us() == move.end_us());
  CHECK(loaded.position(100'000) == move.position(100'000));
  std::vector<std::byte> damaged = out.bytes();
  const std::size_t phases =
      sizeof(std::int64_t) + 8 * sizeof(double);  // begin, two vectors, length, duration
  REQUIRE(damaged[phases] == std::byte(3));
  damaged[phases] = std::byte(4);
  Archive again(damaged);
  CHECK_THROWS_WITH(again(loaded), Catch::Contains("a move of 4 phases"));
}
