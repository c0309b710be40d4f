#include "report/export/run_facts_tables.h"

#include <vector>

#include "runs/folder/notes.h"
#include "runs/folder/run_meta.h"

namespace firn::report {
namespace {

Column text_column(const char* name, const char* about) {
  return {name, schema::Kind::kString, Shape::kOne, "text", about, ""};
}

void write_texts(TableSink& sink, std::size_t table, const std::vector<std::string>& texts) {
  std::vector<Cell> cells;
  for (const std::string& text : texts) cells.push_back({{}, {text}});
  sink.row(table, cells);
}

}  // namespace

void write_meta(const runs::ProvenanceDocument& provenance, const std::string& prefix, TableSink& sink) {
  const runs::RunMeta meta = runs::run_meta(provenance);
  if (meta.values.empty()) return;
  const std::size_t table =
      sink.open({prefix + "provenance/meta",
                 "What was printed: [meta] of the experiment, one row a key.",
                 {text_column("key", "Key of [meta]."), text_column("value", "Its value, as text.")},
                 std::nullopt});
  for (const MetaEntry& e : meta.values) write_texts(sink, table, {e.key, meta_value_text(e.value)});
}

void write_notes(const std::filesystem::path& run, const std::string& prefix, TableSink& sink) {
  const runs::RunNotes notes = runs::read_notes(run);
  if (notes.entries.empty()) return;
  const std::size_t table =
      sink.open({prefix + "provenance/notes",
                 "What people wrote about the run, oldest first.",
                 {text_column("time_utc", "When; empty: an older program kept none."),
                  text_column("author", "Who; empty as above."),
                  text_column("kind", "note, tag, untag: a tag was taken away, or ack: an alarm was seen."),
                  text_column("text", "The note, the name of the tag, or the alarm.")},
                 std::nullopt});
  for (const runs::NoteEntry& e : notes.entries)
    write_texts(sink, table, {e.time_utc, e.author, std::string(runs::note_kind_word(e.kind)), e.text});
}

}  // namespace firn::report
