#include "runs/read/run_log.h"

#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/one_run.h"
#include "runs/folder/run_folder.h"
#include "runs/migrate/table.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

void refuse_damage(const fs::path& log, const record::DamageList& damage) {
  if (damage.count() == 0) return;
  const record::Damage& d = damage.list().front();
  throw std::invalid_argument(log.string() + ": byte " + std::to_string(d.offset) + ": " +
                              std::string(d.reason) +
                              "; `firn log repair` fills a log from the write-ahead files");
}

}  // namespace

RunTexts read_texts(const fs::path& run) {
  require_run(run);
  require_one_run(run);
  const RunPaths paths(run);
  if (!fs::is_regular_file(paths.log_path()))
    throw UsageError(paths.log_path().string() +
                     ": is missing; `firn log repair` makes it from the write-ahead files");
  return {read_file(paths.experiment_path()), read_file(paths.provenance_path()),
          fs::is_regular_file(paths.result_path()) ? read_file(paths.result_path()) : ""};
}

std::uint64_t each_message(const fs::path& run,
                           const std::function<void(const record::Event&, const schema::Type&)>& use,
                           const std::function<void(double)>& progress) {
  const fs::path path = RunPaths(run).log_path();
  const record::EventLogFile log(path);
  record::EventLogReader reader = log.reader();
  std::uint64_t messages = 0;
  double shown = 0;
  while (const auto e = reader.next()) {
    refuse_damage(path, reader.damage());
    const schema::Type* type = runs::MigrationTable::builtin().type_of(e->data);
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

std::invalid_argument bad_message(const fs::path& run, const record::Event& event, const std::string& what) {
  return std::invalid_argument(RunPaths(run).log_path().string() + ": byte " + std::to_string(event.offset) +
                               ": " + std::string(event.channel) + ": " + what);
}

}  // namespace firn::runs
