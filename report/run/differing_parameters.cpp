#include "report/run/differing_parameters.h"

#include <algorithm>

#include "config/fields.h"

namespace firn::report {

std::vector<report::DifferingParameter> differing_parameters(std::vector<Experiment> experiments) {
  std::vector<report::DifferingParameter> rows;
  for (std::size_t n = 0; n < experiments.size(); ++n) {
    const std::vector<Field> table = fields(experiments[n]);
    if (n == 0)
      for (const Field& f : table) rows.push_back({std::string(f.key), std::string(f.unit), {}});
    for (std::size_t k = 0; k < table.size(); ++k) rows[k].values.push_back(value_text(table[k]));
  }
  std::erase_if(rows, [](const report::DifferingParameter& p) {
    return std::ranges::all_of(p.values, [&](const std::string& v) { return v == p.values.front(); });
  });
  return rows;
}

}  // namespace firn::report
