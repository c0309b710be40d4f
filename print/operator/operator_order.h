// OperatorOrder holds one command of the operator to a running print, as firn ctl and the keys of a terminal
// give it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "firn/enums.h"
#include "firn/operator_command_t.hpp"

namespace firn {

struct OperatorOrder {
  std::int64_t id = 0;  ///< as operator_command_t::command_id
  OperatorVerb verb = OperatorVerb::kPause;
  std::string key, value;  ///< kSet
};

/// Reads {"pause"} or {"set", "KEY=VALUE"}. The order gets a number of its own.
/// @throws UsageError naming the word and the words that are known
OperatorOrder parse_order(std::span<const std::string> words);

/// Returns "pause", "set control.max_layers=40".
std::string to_text(const OperatorOrder& order);

/// @param from the sender, for the record: "firn ctl", "key"
operator_command_t to_message(const OperatorOrder& order, const std::string& from);

/// Returns the order that a message holds, as it was given.
OperatorOrder to_order(const operator_command_t& message);

/// Returns a number that no other order has, in [1, 2^53].
std::int64_t new_order_id();

}  // namespace firn
