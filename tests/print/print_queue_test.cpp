// The queue of prints that wait for a lab, against a list that is kept by hand.
#include "print/operator/print_queue.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Contains;

namespace {

QueuedPrint queued(const std::string& experiment) {
  QueuedPrint p;
  p.experiment = experiment;
  p.overrides = {"a.b=\"c, d\"", "e=1"};
  p.meta = {"sample=7"};
  p.tolerance_um = 0.1;
  p.by = "Ada";
  return p;
}

std::vector<std::int64_t> ids(const PrintQueue& q) {
  std::vector<std::int64_t> all;
  for (const QueuedPrint& p : q.prints) all.push_back(p.id);
  return all;
}

}  // namespace

TEST_CASE("A queue keeps the order in which prints were added, through any changes and as read back") {
  const test::TempFolder folder;
  const auto file = queue_file(folder.path());
  RandomStream random(52, Purpose::kTest);
  std::vector<std::int64_t> expected;
  std::int64_t last = 0, begun = 0;
  for (int step = 0; step < 400; ++step) {
    QueueChange change(file);
    PrintQueue& q = change.queue;
    CHECK(ids(q) == expected);
    const std::uint64_t what = random.below(5);
    if (what <= 1 && expected.size() < kMaxQueued) {
      const bool first = what == 1;
      const std::int64_t id = q.add(queued("x"), first);
      CHECK(id == ++last);  // a number is given once
      expected.insert(first ? expected.begin() + (begun != 0) : expected.end(), id);
    } else if (what == 2 && !expected.empty()) {
      const std::int64_t id = expected[random.below(expected.size())];
      CHECK(q.remove(id));
      CHECK_FALSE(q.remove(id));
      std::erase(expected, id);
      if (id == begun) begun = 0;
    } else if (what == 3 && begun == 0 && !expected.empty()) {
      begun = expected.front();
      CHECK(q.begin(begun));
    } else if (what == 4 && begun != 0) {
      q.end(begun, "runs/r", "");
      std::erase(expected, begun);
      begun = 0;
    }
    change.save();
  }
  CHECK(last > 50);
}

TEST_CASE("A queue is read back with every word of its prints") {
  const test::TempFolder folder;
  const auto file = queue_file(folder.path());
  {
    QueueChange change(file);
    change.queue.add(queued("/a b/\"c\".toml"), false);
    change.queue.begin(1);
    change.queue.end(1, "runs/x", "the lamp is disconnected");
    change.queue.clear("Bo \"B\"");
    change.save();
  }
  const PrintQueue q = read_queue(file);
  REQUIRE(q.prints.size() == 1);
  const QueuedPrint &p = q.prints[0], wanted = queued("/a b/\"c\".toml");
  CHECK(p.experiment == wanted.experiment);
  CHECK(p.overrides == wanted.overrides);
  CHECK(p.meta == wanted.meta);
  CHECK(p.tolerance_um == wanted.tolerance_um);
  CHECK(p.by == wanted.by);
  CHECK(p.run == "runs/x");
  CHECK(p.why == "the lamp is disconnected");
  CHECK(q.cleared_by == "Bo \"B\"");
}

TEST_CASE("The word that the bed is clear is good for one print, and comes back with one that was refused") {
  PrintQueue q;
  q.add(queued("x"), false);
  q.clear("Ada");
  q.begin(1);
  CHECK(q.cleared_by.empty());
  CHECK_FALSE(q.prints[0].began_utc.empty());
  q.put_back(1, "Ada");
  CHECK(q.cleared_by == "Ada");
  CHECK(q.prints[0].began_utc.empty());
}

TEST_CASE("A print that is not the next one any more does not begin, and the bed stays clear") {
  PrintQueue q;
  q.add(queued("x"), false);
  q.add(queued("y"), false);
  q.clear("Ada");
  CHECK_FALSE(q.begin(2));
  q.remove(1);
  CHECK_FALSE(q.begin(1));
  CHECK(q.cleared_by == "Ada");
  CHECK(q.prints[0].began_utc.empty());
  CHECK(q.begin(2));
}

TEST_CASE("A queue has a largest number of prints, which is named") {
  PrintQueue q;
  for (std::size_t n = 0; n < kMaxQueued; ++n) q.add(queued("x"), n % 2 == 0);
  CHECK_THROWS_WITH(q.add(queued("x"), false), Contains("1000 prints"));
  CHECK(q.prints.size() == kMaxQueued);
}

TEST_CASE("A change of a queue that is not saved leaves the file as it was") {
  const test::TempFolder folder;
  const auto file = queue_file(folder.path());
  {
    QueueChange change(file);
    change.queue.add(queued("x"), false);
    change.save();
  }
  const std::string before = read_file(file);
  { QueueChange(file).queue.remove(1); }
  CHECK(read_file(file) == before);
}

TEST_CASE("A second worker at one queue is refused by the number of the first, and free when that has died") {
  const test::TempFolder folder;
  const auto file = queue_file(folder.path());
  int ready[2];
  REQUIRE(::pipe(ready) == 0);
  const pid_t first = ::fork();
  if (first == 0) {
    const QueueTurn turn(file);
    (void)!::write(ready[1], "x", 1);
    ::pause();
    ::_exit(0);
  }
  char byte = 0;
  REQUIRE(::read(ready[0], &byte, 1) == 1);
  CHECK_THROWS_WITH(QueueTurn(file), Contains("pid " + std::to_string(first)));
  ::kill(first, SIGKILL);
  REQUIRE(::waitpid(first, nullptr, 0) == first);
  CHECK_NOTHROW(QueueTurn(file));
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST_CASE("The digest of an experiment changes with the file and with each file that it includes") {
  const test::TempFolder folder;
  const auto lab = folder.file("lab.toml", "[run]\nname = \"x\"\n");
  const auto file = folder.file("e.toml", "include = \"lab.toml\"\n");
  const std::string before = experiment_digest(file);
  CHECK(experiment_digest(file) == before);
  folder.file("lab.toml", "[run]\nname = \"y\"\n");
  CHECK(experiment_digest(file) != before);
  folder.file("lab.toml", "[run]\nname = \"x\"\n");
  folder.file("e.toml", "include = \"lab.toml\"\n# more\n");
  CHECK(experiment_digest(file) != before);
}
