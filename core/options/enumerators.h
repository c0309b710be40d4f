// Counts the enumerators of an enumeration at compile time, so that a table beside it cannot be too short.
#pragma once

#include <cstddef>
#include <utility>

namespace firn {
namespace detail {

/// True if E has an enumerator of this value. The compilers write an enumerator by its name,
/// "firn::Kind::kIo" or
/// "(anonymous namespace)::Kind::kIo", and any other value as a cast, "(firn::Kind)9".
template <class E, E kValue>
constexpr bool is_enumerator() {
  bool is_cast = false;
  for (const char* at = __PRETTY_FUNCTION__; *at; ++at)
    if (*at == ')') is_cast = at[1] == '-' || (at[1] >= '0' && at[1] <= '9');
  return !is_cast;
}

template <class E, std::size_t... kValues>
constexpr std::size_t table_size(std::index_sequence<kValues...>) {
  std::size_t size = 0;
  ((size = is_enumerator<E, E(kValues)>() ? kValues + 1 : size), ...);
  return size;
}

}  // namespace detail

/// Entries of a table that is indexed by E: the greatest value plus one. Values are below 64.
///     static_assert(std::size(kWords) == kTableSize<EventKind>);
template <class E>
inline constexpr std::size_t kTableSize = detail::table_size<E>(std::make_index_sequence<64>());

}  // namespace firn
