// write_meta and write_notes export [meta] of a run, and what people wrote about it, as tables of texts.
#pragma once

#include <filesystem>
#include <string>

#include "report/export/tables.h"
#include "runs/folder/documents.h"

namespace firn::report {

/// Writes provenance/meta: key and value. Nothing without a key. @param prefix "RUN/" of several runs
void write_meta(const runs::ProvenanceDocument& provenance, const std::string& prefix, TableSink& sink);

/// Writes provenance/notes: time, author, kind and text, oldest first. Nothing without notes and tags.
void write_notes(const std::filesystem::path& run, const std::string& prefix, TableSink& sink);

}  // namespace firn::report
