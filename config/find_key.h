// Finds configuration keys by words of their names and of their sentences.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"

namespace firn {

/// A name that laboratories use for what a key is called otherwise. A name may stand for several keys.
struct NameOfTheField {
  std::string_view name, key;
};
std::span<const NameOfTheField> names_of_the_field();

/// Returns the fields that every word of `query` is found in, best first: whole words of the key before
/// beginnings of words, words of the key before words of the sentence. Keys that laboratories call otherwise
/// come first, such as grid.pitch_x_mm for "droplet spacing". A word of four letters or more may
/// have a wrong letter, one of seven or more two.
std::vector<const Field*> find_fields(const std::vector<Field>& table, std::string_view query);

/// Returns the known key that shares most words with an unknown one; "" if its name is like no key's name. A
/// word without a section is compared with all words of a key.
std::string likeliest_key(const std::vector<Field>& table, std::string_view unknown);

}  // namespace firn
