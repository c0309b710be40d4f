#include "files/nearest.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace firn {

std::string nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  word = word.substr(0, 200);  // bounds the table of distances for any file
  std::string_view best;
  std::size_t best_distance = (word.size() + 1) / 2 + 1;
  for (std::string_view candidate : candidates) {
    std::vector<std::size_t> row(candidate.size() + 1);  // Levenshtein, one row at a time
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < word.size(); ++i) {
      std::size_t diagonal = std::exchange(row[0], i + 1);
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t replace = diagonal + (word[i] != candidate[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({replace, row[j] + 1, diagonal + 1});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return std::string(best);
}

}  // namespace firn
