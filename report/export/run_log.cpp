#include "report/export/run_log.h"

#include "files/text_file.h"
#include "files/usage_error.h"
#include "replay/migrations/table.h"

namespace firn::tables {
namespace {

namespace fs = std::filesystem;

void refuse_damage(const fs::path& log, const logfile::DamageList& damage) {
  if (damage.count() == 0) return;
  const logfile::Damage& d = damage.list().front();
  throw std::invalid_argument(log.string() + ": byte " + std::to_string(d.offset) + ": " +
                              std::string(d.reason) +
                              "; `firn log repair` fills a log from the write-ahead files");
}

}  // namespace

RunTexts read_texts(const fs::path& run) {
  for (const char* file : {"experiment.toml", "provenance.json"})
    if (!fs::is_regular_file(run / file))
      throw UsageError(run.string() + ": not a run folder: " + (run / file).string() + " is missing");
  if (!fs::is_regular_file(run / "log.lcm"))
    throw UsageError((run / "log.lcm").string() +
                     ": is missing; `firn log repair` makes it from the write-ahead files");
  return {read_file(run / "experiment.toml"), read_file(run / "provenance.json"),
          fs::is_regular_file(run / "result.json") ? read_file(run / "result.json") : ""};
}

std::uint64_t each_message(const fs::path& run,
                           const std::function<void(const logfile::Event&, const schema::Type&)>& use,
                           const std::function<void(double)>& progress) {
  const fs::path path = run / "log.lcm";
  const logfile::EventLogFile log(path);
  logfile::EventLogReader reader = log.reader();
  std::uint64_t messages = 0;
  double shown = 0;
  while (const auto e = reader.next()) {
    refuse_damage(path, reader.damage());
    const schema::Type* type = replay::MigrationTable::builtin().type_of(e->data);
    if (!type) throw bad_message(run, *e, "a message of unknown type");
    use(*e, *type);
    ++messages;
    log.forget_before(e->offset);
    const double fraction = double(e->offset) / double(log.bytes().size());
    if (fraction - shown < 0.01) continue;
    progress(fraction);
    shown = fraction;
  }
  refuse_damage(path, reader.damage());
  if (messages == 0) throw std::invalid_argument(path.string() + ": holds no message");
  return messages;
}

std::invalid_argument bad_message(const fs::path& run, const logfile::Event& event, const std::string& what) {
  return std::invalid_argument((run / "log.lcm").string() + ": byte " + std::to_string(event.offset) + ": " +
                               std::string(event.channel) + ": " + what);
}

}  // namespace firn::tables
