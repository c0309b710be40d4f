// Declares the JSON library, nlohmann's, as compiled once, in json.cpp, instead of in each source that calls
// it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace firn::detail {
using JsonText = decltype(nlohmann::detail::input_adapter(std::declval<const std::string&>()));
}

extern template class nlohmann::basic_json<>;
extern template class nlohmann::detail::serializer<nlohmann::json>;
extern template class nlohmann::detail::lexer<nlohmann::json, firn::detail::JsonText>;
extern template class nlohmann::detail::parser<nlohmann::json, firn::detail::JsonText>;

extern template class nlohmann::basic_json<nlohmann::ordered_map>;
extern template class nlohmann::detail::serializer<nlohmann::ordered_json>;
extern template class nlohmann::detail::lexer<nlohmann::ordered_json, firn::detail::JsonText>;
extern template class nlohmann::detail::parser<nlohmann::ordered_json, firn::detail::JsonText>;
