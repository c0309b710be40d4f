// Holds the table of limits against the members of the types.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "lcmtypes/limits.h"
#include "lcmtypes/schema.h"

namespace firn {

inline bool has_field(const schema::Type& type, std::string_view path) {
  return std::any_of(type.fields.begin(), type.fields.end(), [&](const auto& f) { return f.path == path; });
}
inline bool has_limit(const schema::Type& type, const schema::Field& field) {
  return std::any_of(limits().begin(), limits().end(), [&](const Limit& l) {
    return l.when.empty() && l.type == type.name && l.path == field.path;
  });
}

/// Rows of the limits table that name no member of any type: empty, or a rename has lost a limit.
inline std::vector<std::string> unmatched_limits() {
  std::vector<std::string> lost;
  const auto known = [](std::string_view type, std::string_view path) {
    for (const schema::Type& t : Schema::builtin().types())
      if (type == t.name && has_field(t, path)) return true;
    return false;
  };
  const auto demand = [&](std::string_view type, std::string_view path) {
    if (!path.empty() && !known(type, path)) lost.push_back(std::string(type) + "." + std::string(path));
  };
  for (const Limit& l : limits()) {
    demand(l.type, l.path);
    demand(l.type, l.when);
  }
  for (const Relation& r : relations())
    for (const std::string_view path : {r.a, r.b, r.c, r.when}) demand(r.type, path);
  return lost;
}

/// Numbers, "type.path", for which no row of the table sets a limit.
inline std::vector<std::string> unlimited_members() {
  std::vector<std::string> free;
  for (const schema::Type& t : Schema::builtin().types())
    for (const schema::Field& f : t.fields)
      if (f.kind < schema::Kind::kString && !has_limit(t, f)) free.push_back(t.name + "." + f.path);
  return free;
}

}  // namespace firn
