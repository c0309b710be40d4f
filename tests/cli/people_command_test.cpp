// firn people: who may read and command on the page.
#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "files/json.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

using Catch::Contains;

/// A table of its own.
struct PeopleTable {
  explicit PeopleTable(const std::string& name)
      : file((fresh_folder("people-" + name) / "people").string()) {}
  Said says(std::vector<std::string> words) const {
    words.insert(words.begin(), "people");
    words.insert(words.end(), {"--file", file});
    return firn_says(words);
  }
  std::string file;
};

}  // namespace

TEST_CASE("firn people adds a person with a token that the table does not hold, and takes him out again") {
  const PeopleTable table("add");
  const Said added = table.says({"add", "Ada Lovelace", "--role", "operator", "--json"});
  REQUIRE(added.code == 0);
  const std::string token = nlohmann::json::parse(added.out)["token"];
  CHECK(token.size() >= 32);
  CHECK(file_text(table.file).find(token) == std::string::npos);
  struct stat found {};
  REQUIRE(::stat(table.file.c_str(), &found) == 0);
  CHECK((found.st_mode & 0777) == 0600);
  CHECK_THAT(table.says({"list"}).out, Contains("operator  Ada Lovelace"));
  CHECK(table.says({"remove", "Ada Lovelace"}).code == 0);
  CHECK_THAT(table.says({"list"}).out, Contains("nobody"));
}

TEST_CASE("firn people refuses a role, a name and a table that are none, and changes nothing") {
  const PeopleTable table("refuse");
  REQUIRE(table.says({"add", "Ada"}).code == 0);
  const std::string before = file_text(table.file);
  CHECK_THAT(table.says({"add", "Bo", "--role", "king"}).err, Contains("observer, operator or proxy"));
  CHECK(table.says({"add", "a:b"}).code == 2);
  CHECK(table.says({"add", "Ada"}).code == 2);
  CHECK_THAT(table.says({"remove", "Bo"}).err, Contains("has no Bo"));
  CHECK(file_text(table.file) == before);
  ::chmod(table.file.c_str(), 0666);
  CHECK_THAT(table.says({"list"}).err, Contains(table.file) && Contains("chmod 600"));
}

}  // namespace firn::test
