// labelled_edges() tells the names or numbers of columns and rows, as pandas writes them around a matrix,
// from its values.
#pragma once

#include <string>
#include <vector>

#include "files/layer_record.h"
#include "files/separated_values.h"

namespace firn {

struct LabelledEdges {
  bool row = false, column = false;  ///< the first row, the first column is no part of the matrix
  std::string assumption;            ///< a sentence where this was detected
};

/// @throws UsageError naming file and line where a first row or column 0, 1, 2, ... could be either
LabelledEdges labelled_edges(const SeparatedValues& table, const std::vector<SeparatedRow>& rows,
                             MatrixLabels labels);

}  // namespace firn
