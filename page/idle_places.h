// IdlePlaces holds the connections that wait for a request, and closes old ones to make room for newcomers.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <string>

namespace firn::page {

class IdlePlaces {
  struct Waiting {
    std::string from;
    std::function<void()> close;
  };
  using List = std::list<std::shared_ptr<const Waiting>>;  // longest wait first

 public:
  static constexpr std::size_t kMaxFromOne = 100;

  /// The time in which a connection waits.
  class Place {
   public:
    Place(List& list, std::shared_ptr<const Waiting> mine) : list_(list), mine_(std::move(mine)) {}
    ~Place() { list_.remove(mine_); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    List& list_;
    std::shared_ptr<const Waiting> mine_;
  };

  /// Takes a connection that waits from now on. Where kMaxFromOne of its address wait, the first of them is
  /// closed. @param close must not end a Place by itself, but soon
  Place enter(std::string from, std::function<void()> close);
  /// Closes the connection that has waited longest, from anywhere. @returns false: none waits
  bool make_room();

 private:
  List list_;
};

}  // namespace firn::page
