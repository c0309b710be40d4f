#include "config/assumptions.h"

#include <algorithm>
#include <utility>

#include "config/fields.h"

namespace firn {

char mark_of(std::string_view meaning) {
  for (std::size_t n = meaning.size(); n-- > 2;)
    if (meaning[n] == ']' && meaning[n - 2] == '[' &&
        std::string_view("CSMPU").find(meaning[n - 1]) != std::string_view::npos)
      return meaning[n - 1];
  return 0;
}

bool unproven(char mark) { return mark == 'M' || mark == 'P' || mark == 'U'; }

std::vector<Assumption> assumptions(const Experiment& experiment, std::string_view node) {
  Experiment e = experiment;
  const std::string own = std::string(node), dialect = "devices." + own + ".dialect";
  std::vector<Assumption> all;
  for (const Field& f : fields(e))
    if (const char mark = mark_of(f.meaning); mark != 0 && (f.section() == own || f.section() == dialect))
      all.push_back({f.key, value_text(f), mark, f.meaning});
  return all;
}

std::string assumptions_text(const Experiment& experiment, std::string_view node) {
  const auto all = assumptions(experiment, node);
  static constexpr std::pair<char, const char*> kEvidence[] = {{'C', "by its maker's text or two codebases"},
                                                               {'S', "by one public source"},
                                                               {'M', "from memory"},
                                                               {'P', "chosen here"},
                                                               {'U', "inferred"}};
  std::string text, without;
  for (const auto& [mark, evidence] : kEvidence) {
    const auto n = std::ranges::count(all, mark, &Assumption::mark);
    if (n > 0) text += (text.empty() ? "" : ", ") + std::to_string(n) + " " + evidence + " [" + mark + "]";
  }
  for (const Assumption& a : all)
    if (unproven(a.mark))
      without +=
          (without.empty() ? "; to check on yours: " : ", ") + a.key + " = " + a.value + " [" + a.mark + "]";
  return text.empty() ? text : "settings of its protocol: " + text + without;
}

}  // namespace firn
