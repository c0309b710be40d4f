#include <catch2/catch.hpp>

#include <optional>
#include <vector>

#include "page/idle_places.h"

using firn::page::IdlePlaces;

namespace {

/// Connections that note in which order they are closed.
class Connections {
 public:
  void come(const std::string& from) {
    const int number = int(places_.size());
    places_.push_back(std::make_unique<Held>(idle, from, [this, number] { closed.push_back(number); }));
  }
  void leave(int number) { places_[std::size_t(number)].reset(); }

  IdlePlaces idle;
  std::vector<int> closed;

 private:
  struct Held {
    Held(IdlePlaces& idle, const std::string& from, std::function<void()> close)
        : place(idle.enter(from, std::move(close))) {}
    IdlePlaces::Place place;
  };
  std::vector<std::unique_ptr<Held>> places_;
};

}  // namespace

TEST_CASE("the connection that has waited longest makes room for a newcomer") {
  Connections c;
  for (const char* from : {"a", "b", "a", "c"}) c.come(from);
  c.leave(1);
  while (c.idle.make_room()) {
  }
  CHECK(c.closed == std::vector<int>{0, 2, 3});
}

TEST_CASE("a connection that waits no more is not closed") {
  Connections c;
  c.come("a");
  c.leave(0);
  CHECK_FALSE(c.idle.make_room());
  CHECK(c.closed.empty());
}

TEST_CASE("one address that opens ever more connections closes its own, not those of others") {
  Connections c;
  c.come("other");
  for (std::size_t n = 0; n < 2 * IdlePlaces::kMaxFromOne; ++n) c.come("flood");
  REQUIRE(c.closed.size() == IdlePlaces::kMaxFromOne);
  for (std::size_t n = 0; n < c.closed.size(); ++n) CHECK(c.closed[n] == int(n) + 1);
}
