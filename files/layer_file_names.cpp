#include "files/layer_file_names.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>

#include "core/options/number.h"
#include "files/layer_limits.h"
#include "files/lowercase.h"
#include "files/usage_error.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLayerWords[] = {"layer", "layers", "lay", "l", "slice", "schicht"};

struct NameNumber {
  std::string word;  ///< letters before it
  std::optional<std::int32_t> value;
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

std::vector<NameNumber> numbers_of(const std::string& stem) {
  std::vector<NameNumber> numbers;
  for (std::size_t at = 0; at < stem.size(); ++at) {
    if (!is_digit(stem[at])) continue;
    std::size_t word_end = at;
    while (word_end > 0 && std::string_view("-_. #").find(stem[word_end - 1]) != std::string_view::npos)
      --word_end;
    std::size_t word = word_end;
    while (word > 0 && is_letter(stem[word - 1])) --word;
    const std::size_t first = at;
    while (at < stem.size() && is_digit(stem[at])) ++at;
    numbers.push_back({lowercase(stem.substr(word, word_end - word)),
                       whole_number<std::int32_t>(std::string_view(stem).substr(first, at - first))});
  }
  return numbers;
}

bool is_layer_word(const NameNumber& n) {
  return std::ranges::find(kLayerWords, n.word) != std::end(kLayerWords);
}

std::string shown(const std::optional<std::int32_t>& value) {
  return value ? std::to_string(*value) : "a long number";
}

class LayerNames {
 public:
  LayerNames(const std::vector<fs::path>& files, int layer_number) : files_(files), chosen_(layer_number) {
    for (const fs::path& file : files) {
      names_.push_back(numbers_of(file.stem().string()));
      if (names_.back().empty()) throw UsageError(file.string() + ": no number of a layer in its name");
    }
  }

  /// The place of the layer among the numbers of the n-th file.
  std::size_t place(std::size_t n) const {
    const auto& numbers = names_[n];
    if (chosen_ != 0) {
      const std::size_t from_end = chosen_ < 0 ? std::size_t(-chosen_) : 0;
      if (std::size_t(std::abs(chosen_)) > numbers.size())
        throw UsageError(fmt::format("{}: --layer-number {}: the name has {} numbers", files_[n].string(),
                                     chosen_, numbers.size()));
      return chosen_ < 0 ? numbers.size() - from_end : std::size_t(chosen_ - 1);
    }
    if (numbers.size() == 1) return 0;
    const bool named = std::ranges::all_of(
        names_, [](const auto& all) { return std::ranges::count_if(all, is_layer_word) == 1; });
    if (named) return std::size_t(std::ranges::find_if(numbers, is_layer_word) - numbers.begin());
    return varying();
  }

 private:
  /// The only number that is not the same in all names.
  std::size_t varying() const {
    const std::size_t count = names_.front().size();
    for (std::size_t n = 0; n < names_.size(); ++n)
      if (names_[n].size() != count)
        throw UsageError(
            fmt::format("{} has {} numbers in its name, {} has {}: --layer-number 1 takes the first, "
                        "-1 the last as the layer",
                        files_.front().string(), count, files_[n].string(), names_[n].size()));
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < count; ++k)
      if (names_.size() == 1 || std::ranges::any_of(names_, [&](const auto& all) {
            return all[k].value != names_.front()[k].value;
          }))
        places.push_back(k);
    if (places.size() == 1) return places.front();
    if (places.empty()) return count - 1;
    std::string readings;
    for (const std::size_t k : places) {
      readings += readings.empty() ? "" : ", or ";
      for (std::size_t n = 0; n < std::min<std::size_t>(3, names_.size()); ++n)
        readings += (n > 0 ? ", " : "") + shown(names_[n][k].value);
      readings += (names_.size() > 3 ? ", ... " : " ") + fmt::format("(--layer-number {})", k + 1);
    }
    throw UsageError(
        fmt::format("{}: which number of the name is the layer: {}?", files_.front().string(), readings));
  }

  const std::vector<fs::path>& files_;
  int chosen_;
  std::vector<std::vector<NameNumber>> names_;

 public:
  const NameNumber& number(std::size_t n) const { return names_[n][place(n)]; }
};

}  // namespace

std::map<int, fs::path> layers_by_name(const std::vector<fs::path>& files, int layer_number) {
  const LayerNames names(files, layer_number);
  std::map<int, fs::path> layers;
  for (std::size_t n = 0; n < files.size(); ++n) {
    const auto layer = names.number(n).value;
    if (!layer || *layer > kMaxLayers)
      throw UsageError(fmt::format("{}: {} in its name is no layer from 0 to {}", files[n].string(),
                                   shown(layer), kMaxLayers));
    if (const auto [at, added] = layers.emplace(*layer, files[n]); !added)
      throw UsageError(fmt::format("{}: a second file of layer {}, beside {}", files[n].string(), *layer,
                                   at->second.filename().string()));
  }
  return layers;
}

}  // namespace firn
