#include "config/find_key.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

#include "files/nearest.h"

namespace firn {
namespace {

constexpr int kSame = 8, kBegins = 5, kSimilar = 4;  // a word of the key
constexpr int kSaid = 2, kSaidBegins = 1;            // a word of the sentence
constexpr std::size_t kShortest = 3;                 // of a beginning
constexpr std::size_t kMaxWords = 16;

std::vector<std::string> words_of_text(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char c : text.substr(0, 2000)) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u))
      words.back() += char(std::tolower(u));
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

bool begins(const std::string& a, const std::string& b) {
  const std::size_t n = std::min(a.size(), b.size());
  return n >= kShortest && a.compare(0, n, b, 0, n) == 0;
}

// Units are in many names and tell little of any.
bool is_unit(const std::string& word) {
  constexpr std::string_view kUnits[] = {"mm", "um", "us", "ms", "s", "hz", "deg", "degc", "mm2", "mm3", "v"};
  return std::ranges::find(kUnits, word) != std::end(kUnits);
}

int key_score(const std::string& word, const std::vector<std::string>& key) {
  int best = 0;
  for (const std::string& k : key)
    best = std::max(best, word == k                                                           ? kSame
                          : begins(word, k)                                                   ? kBegins
                          : word.size() >= 4 && edit_distance(word, k) <= word.size() / 7 + 1 ? kSimilar
                                                                                              : 0);
  return best;
}

int said_score(const std::string& word, const std::vector<std::string>& sentence) {
  int best = 0;
  for (const std::string& s : sentence)
    best = std::max(best, word == s ? kSaid : begins(word, s) ? kSaidBegins : 0);
  return best;
}

}  // namespace

std::vector<const Field*> find_fields(const std::vector<Field>& table, std::string_view query) {
  std::vector<std::string> wanted = words_of_text(query);
  if (wanted.size() > kMaxWords) wanted.resize(kMaxWords);
  std::vector<std::pair<int, const Field*>> found;
  for (const Field& f : table) {
    const auto key = words_of_text(f.key), sentence = words_of_text(f.meaning);
    int sum = 0;
    const bool all = std::ranges::all_of(wanted, [&](const std::string& w) {
      const int score = std::max(key_score(w, key), said_score(w, sentence));
      sum += score;
      return score > 0;
    });
    if (all && !wanted.empty()) found.emplace_back(sum, &f);
  }
  std::ranges::stable_sort(found, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<const Field*> fields;
  for (const auto& [score, field] : found) fields.push_back(field);
  return fields;
}

std::string likeliest_key(const std::vector<Field>& table, std::string_view unknown) {
  std::vector<std::string> wanted = words_of_text(unknown);
  if (wanted.empty() || wanted.size() > kMaxWords) return "";
  const bool section_only = unknown.find('.') == std::string_view::npos;
  const std::vector<std::string> name = words_of_text(unknown.substr(unknown.rfind('.') + 1));
  std::vector<std::string_view> best;
  int most = 0;
  for (const Field& f : table) {
    const auto key = words_of_text(f.key), last = words_of_text(f.name());
    int sum = 0, of_name = 0;
    for (const std::string& w : wanted) sum += key_score(w, key);
    for (const std::string& w : name)
      if (!is_unit(w)) of_name += key_score(w, section_only ? key : last);
    sum += key_score(wanted.front(), {key.front()}) > 0;
    if (of_name == 0) continue;
    sum += 2 * of_name - int(key.size());  // a key with fewer further words is likelier
    if (sum > most) best.clear();
    if (sum >= most) best.push_back(f.key);
    most = std::max(most, sum);
  }
  const std::string near = nearest(unknown, best);
  return !near.empty() || best.empty() ? near : std::string(best.front());
}

}  // namespace firn
