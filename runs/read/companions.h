// migration_of makes the migration of one run: with the messages of retired channels that its nodes recorded.
#pragma once

#include <filesystem>

#include "runs/migrate/run_migration.h"

namespace firn::runs {

/// Reads the messages of retired channels, if any, from all write-ahead files of the run. Unreadable files
/// are skipped: replay reports them.
RunMigration migration_of(const std::filesystem::path& run,
                          const MigrationTable& table = MigrationTable::builtin());

}  // namespace firn::runs
