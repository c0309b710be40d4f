// PromiseRow holds how an answer of firn tune fared in one laboratory.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace firn::tune {

struct PromiseRow {
  std::string kind;
  int lab = 0;
  std::string keys;
  std::string answer;                            ///< unfinished, refused, kept, advised
  std::string feature;                           ///< refused: the one missed most
  double before = 0.0;                           ///< mean goal with the recorded setting, as printed [um]
  double promised = 0.0, low = 0.0, high = 0.0;  ///< gain and its interval
  double printed = 0.0;                          ///< gain
  double oracle = 0.0;                           ///< gain of a search in the laboratory itself
  int stopped_more = 0;                          ///< prints that stop with the new setting only
  double cpu_s = 0.0;                            ///< of the answer

  bool answered() const { return answer == "kept" || answer == "advised"; }
  bool covered() const { return printed >= low && printed <= high; }
};

/// Returns a row as one JSON object, and the row of such a text, the same to the last bit.
/// @throws nlohmann::json::exception: the text is no row
std::string row_text(const PromiseRow& row);
PromiseRow row_of(const std::string& text);

/// Share of the mean by which a print may be worse before advice counts as harm.
inline constexpr double kHarm = 0.02;

/// Returns a table: a line a kind, then all laboratories of known classes and all others.
std::string promise_table(std::span<const PromiseRow> rows);

/// True for kinds whose laboratories are of a class that the tuner knows.
bool known_class(const std::string& kind);

}  // namespace firn::tune
