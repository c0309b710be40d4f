// A run folder that is moved, deleted or damaged while it is watched.
#include "runs/folder/folder_watch.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <thread>

#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Contains;
namespace fs = std::filesystem;

TEST_CASE("A run folder whose deletion is under way is said to be deleted, not damaged") {
  const test::TempFolder folder;
  const fs::path run = folder.file("run/provenance.json", "{}").parent_path();
  const runs::FolderWatch watch(run);
  CHECK(watch.trouble().empty());
  fs::remove(run / "provenance.json");
  std::thread deletes([&] {
    ::usleep(20'000);
    fs::remove(run);
  });
  CHECK_THAT(watch.trouble(), Contains("run was deleted"));
  deletes.join();
}

TEST_CASE("A run folder that lost its provenance, or was moved, is told by that") {
  const test::TempFolder folder;
  const fs::path run = folder.file("run/provenance.json", "{}").parent_path();
  const runs::FolderWatch watch(run);
  fs::remove(run / "provenance.json");
  CHECK_THAT(watch.trouble(), Contains("run lost its provenance.json"));
  fs::rename(run, folder.path() / "elsewhere");
  CHECK_THAT(watch.trouble(), Contains("run was moved to ") && Contains("elsewhere"));
}
