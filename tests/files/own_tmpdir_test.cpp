// The folder of temporary files that tests/catch_main.cpp gives to each test program.
#include <catch2/catch.hpp>

#include <filesystem>

#include "tests/support/temp_folder.h"

using namespace firn;

TEST_CASE("Two test programs that run beside each other cannot meet in a temporary file") {
  const std::filesystem::path own = std::filesystem::temp_directory_path();
  CHECK(own.filename().string().starts_with("t-"));
  CHECK(std::filesystem::status(own).permissions() == std::filesystem::perms::owner_all);
  CHECK(test::TempFolder().path().parent_path() == own);
}
