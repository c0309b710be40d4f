#include "page/idle_places.h"

#include <algorithm>
#include <utility>

namespace firn::page {

IdlePlaces::Place IdlePlaces::enter(std::string from, std::function<void()> close) {
  const auto alike = [&](const auto& one) { return one->from == from; };
  if (std::size_t(std::ranges::count_if(list_, alike)) >= kMaxFromOne) {
    const auto oldest = std::ranges::find_if(list_, alike);
    const auto gone = *oldest;
    list_.erase(oldest);
    gone->close();
  }
  auto mine = std::make_shared<const Waiting>(Waiting{std::move(from), std::move(close)});
  list_.push_back(mine);
  return {list_, std::move(mine)};
}

bool IdlePlaces::make_room() {
  if (list_.empty()) return false;
  const auto gone = list_.front();
  list_.pop_front();
  gone->close();
  return true;
}

}  // namespace firn::page
