// RunMeta holds [meta] and the host of a run, as its provenance has them.
#pragma once

#include <string>

#include "config/meta.h"
#include "runs/folder/documents.h"

namespace firn::runs {

struct RunMeta {
  Meta values;       ///< [meta] of the experiment
  std::string host;  ///< that printed it; empty: an older program kept none
};

/// @throws std::invalid_argument naming the key: neither text, number nor boolean
RunMeta run_meta(const ProvenanceDocument& provenance);

/// Returns "operator Kim, sample PCB-7"; empty without values.
std::string meta_words(const Meta& meta);

/// Returns the value of a key as text; empty: it has none.
std::string meta_text(const Meta& meta, std::string_view key);

}  // namespace firn::runs
