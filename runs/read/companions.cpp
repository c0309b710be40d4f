#include "runs/read/companions.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "files/run_paths.h"
#include "lcmtypes/channels.h"
#include "runs/folder/recorded_steps.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

// "struct NAME" of a recorded .lcm text.
std::string struct_of(std::string_view was) { return std::string(was.substr(0, was.find(" {"))); }

bool knows_retired_channel(const MigrationTable& table, const WalHead& head) {
  return std::ranges::any_of(table.retired(), [&](const RetiredChannel& r) {
    return head.type_texts.find(struct_of(r.was)) != std::string::npos;
  });
}

void keep_companions(WalFile& file, RunMigration& to) {
  const auto keep = [&](std::string_view channel, std::span<const std::byte> bytes) {
    if (const RetiredChannel* retired = to.table().retired(channel)) to.keep_companion(*retired, bytes);
  };
  std::vector<Output> outputs;
  for (WalFile::Item item = file.next(); item != WalFile::Item::kEnd; item = file.next()) {
    if (item == WalFile::Item::kHead && !knows_retired_channel(to.table(), file.head())) return;
    if (item != WalFile::Item::kStep && item != WalFile::Item::kStray) continue;
    const RecordedStep& step = file.step();
    if (item == WalFile::Item::kStep && step.event.kind == EventKind::kMessage)
      keep(step.event.channel, step.event.bytes);
    if (!step.has_outputs) continue;
    try {
      decode_output_list(step.outputs, outputs);
    } catch (const std::runtime_error&) {
      continue;
    }
    for (const Output& o : outputs)
      if (o.kind == OutputKind::kSend) keep(o.channel, o.bytes);
  }
}

}  // namespace

RunMigration migration_of(const fs::path& run, const MigrationTable& table) {
  RunMigration migration(table);
  for (const NodeInfo& node : nodes()) {
    const fs::path path = RunPaths(run).wal_path(node.name);
    if (!fs::exists(path)) continue;
    try {
      const auto head = first_head(path);  // of a run of this version it is all that is read
      if (head && !knows_retired_channel(migration.table(), *head)) continue;
      WalFile file(path);
      keep_companions(file, migration);
    } catch (const record::FileError&) {
    }
  }
  return migration;
}

}  // namespace firn::runs
