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

constexpr NameOfTheField kNamesOfTheField[] = {
    {"droplet spacing", "grid.pitch_x_mm"},
    {"drop spacing", "grid.pitch_x_mm"},
    {"dot spacing", "grid.pitch_x_mm"},
    {"resolution", "grid.pitch_x_mm"},
    {"dpi", "grid.pitch_x_mm"},
    {"voxel size", "grid.pitch_x_mm"},
    {"line spacing", "ice.pitch_mm"},
    {"cure time", "process.exposure_s"},
    {"curing time", "process.exposure_s"},
    {"dose", "process.exposure_s"},
    {"layer height", "model.h1_mm"},
    {"layer height", "ice.layer_height_mm"},
    {"layer height", "geometry.image_pitch_z_mm"},
    {"layer thickness", "model.h1_mm"},
    {"layer thickness", "ice.layer_height_mm"},
    {"layer thickness", "geometry.image_pitch_z_mm"},
    {"number of layers", "control.max_layers"},
    {"layer count", "control.max_layers"},
    {"print speed", "process.pass_speed_mm_s"},
    {"print speed", "ice.water_fill_mm_s"},
    {"feed rate", "process.pass_speed_mm_s"},
    {"feed rate", "ice.water_fill_mm_s"},
    {"travel speed", "robot.travel_mm_s"},
    {"standoff", "process.nozzle_gap_mm"},
    {"stand off", "process.nozzle_gap_mm"},
    {"working distance", "process.nozzle_gap_mm"},
    {"nozzle height", "process.nozzle_gap_mm"},
    {"flow rate", "aerosol.flow_mm3_s"},
    {"flow rate", "plant.flow"},
    {"droplet volume", "model.h1_mm"},
    {"droplet volume", "plant.flow"},
    {"drop volume", "model.h1_mm"},
    {"drop volume", "plant.flow"},
    {"viscosity", "model.h2_mm"},
    {"viscosity", "model.h3_mm"},
    {"viscosity", "plant.spread"},
    {"wetting", "model.h2_mm"},
    {"wetting", "plant.spread"},
    {"contact angle", "plant.spread"},
    {"droplet size", "plant.spread"},
    {"droplet diameter", "plant.spread"},
    {"drop size", "plant.spread"},
    {"controller", "control.scheme"},
    {"algorithm", "control.scheme"},
    {"proportional gain", "control.smf.kp"},
    {"uv power", "process.iris_percent"},
    {"uv intensity", "process.iris_percent"},
    {"jetting frequency", "jet.max_rate_hz"},
    {"drop rate", "jet.max_rate_hz"},
};

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

// The keys that a query means by the field's own names, in the table's order.
std::vector<std::string_view> keys_of_names(const std::vector<std::string>& wanted) {
  std::vector<std::string_view> keys;
  for (const auto& [name, key] : kNamesOfTheField) {
    const std::vector<std::string> words = words_of_text(name);
    if (std::ranges::all_of(
            words, [&](const std::string& w) { return std::ranges::find(wanted, w) != wanted.end(); }))
      keys.push_back(key);
  }
  return keys;
}

}  // namespace

std::span<const NameOfTheField> names_of_the_field() { return kNamesOfTheField; }

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
  for (const std::string_view key : keys_of_names(wanted))
    for (const Field& f : table)
      if (f.key == key) fields.push_back(&f);
  for (const auto& [score, field] : found)
    if (std::ranges::find(fields, field) == fields.end()) fields.push_back(field);
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
