#include "runs/find/run_index.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include "files/record/checksum.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/find/database.h"
#include "runs/find/query_sql.h"
#include "runs/find/run_facts.h"
#include "runs/find/run_state.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/running.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kVersion = 1;      // of the tables; an index of another one is made anew
constexpr std::size_t kRunsAtOnce = 100;  // in a transaction: other processes wait for it

constexpr const char* kTables = R"(
CREATE TABLE runs(id INTEGER PRIMARY KEY, place TEXT NOT NULL, name TEXT NOT NULL, state INTEGER NOT NULL,
  lab TEXT NOT NULL, settings INTEGER NOT NULL, ended INTEGER NOT NULL, running INTEGER NOT NULL,
  listing TEXT NOT NULL, checksum INTEGER NOT NULL, UNIQUE(place, name));
CREATE TABLE facts(run INTEGER NOT NULL, key TEXT NOT NULL, number REAL, word TEXT NOT NULL);
CREATE TABLE texts(run INTEGER PRIMARY KEY, word TEXT NOT NULL);
CREATE INDEX facts_by_number ON facts(key, number, run);
CREATE INDEX facts_by_word ON facts(key, word, run);
CREATE INDEX facts_by_run ON facts(run);
)";

// A place as it is asked for: a folder of runs, or one run in it.
struct Place {
  fs::path folder, given;
  std::string only;  // name of the run; empty: all
};

Place place_of_path(const fs::path& given) {
  if (!fs::is_directory(given))
    throw UsageError(given.string() +
                     ": no such folder: nothing has been printed there yet; --runs names another");
  const fs::path canonical = fs::canonical(given);
  if (!is_run(canonical)) return {canonical, given, ""};
  return {canonical.parent_path(), given, canonical.filename().string()};
}

std::int64_t checksum_of(const std::string& text) {
  return std::int64_t(record::checksum64(std::as_bytes(std::span(text))));
}

}  // namespace

class RunIndex::Database {
 public:
  explicit Database(const fs::path& file) : file_(file), connection_(file) {
    check_sum();
    connection_.carry_out(
        "PRAGMA journal_mode = TRUNCATE; PRAGMA synchronous = NORMAL; PRAGMA cache_size = -65536");
    Transaction transaction(connection_);
    Statement version(connection_.get(), "PRAGMA user_version");
    version.step();
    const std::int64_t found = version.integer(0);
    version.reset();
    if (found == kVersion) return;
    if (found != 0) throw DamagedDatabase("it is of another version");
    connection_.carry_out(kTables);
    connection_.carry_out("PRAGMA user_version = " + std::to_string(kVersion));
    transaction.commit();
  }

  IndexReport refresh(const std::vector<Place>& places, const Progress& progress) {
    IndexReport report;
    std::vector<Changed> changed;
    for (const Place& place : places) look(place, changed, report);
    for (std::size_t n = 0; n < changed.size();) {
      // Read outside of the transaction: reading takes longer than writing.
      std::vector<std::pair<RunEntry, RunFacts>> read;
      const std::size_t from = n;
      for (; n < changed.size() && n - from < kRunsAtOnce; ++n) {
        RunEntry entry = run_entry(changed[n].place / changed[n].name);
        RunFacts facts = run_facts(entry, true);
        read.emplace_back(std::move(entry), std::move(facts));
        if (progress) progress(double(n + 1) / double(changed.size()));
      }
      Transaction transaction(connection_);
      for (std::size_t k = 0; k < read.size(); ++k) keep(changed[from + k], read[k].first, read[k].second);
      transaction.commit();
    }
    report.read = changed.size();
    if (report.read > 0 || report.gone > 0) keep_sum();
    return report;
  }

  std::vector<FoundRun> find(const SqlCondition& condition, const std::vector<Place>& places,
                             const FindOptions& options) {
    std::string where;
    for (const Place& place : places)
      where += std::string(where.empty() ? "(" : " OR ") +
               (place.only.empty() ? "place = ?" : "(place = ? AND name = ?)");
    std::string sql =
        "SELECT place, name, listing, checksum, s.number, s.word FROM runs r LEFT JOIN "
        "(SELECT run, min(number) number, min(word) word FROM facts WHERE key = ? GROUP BY run) s ON s.run = "
        "r.id "
        "WHERE " +
        where + ") AND (" + condition.text + ") ORDER BY s.word IS NULL";
    // Names begin with the time: of two runs of one second the later one is the newer, too.
    for (const char* column : {"s.number", "s.word", "place", "name"})
      sql += std::string(", ") + column + (options.descending ? " DESC" : " ASC");
    if (options.limit > 0) sql += " LIMIT " + std::to_string(options.limit);
    Statement rows(connection_.get(), sql);
    rows.bind(std::string_view(options.sort));
    std::vector<std::string> names;
    for (const Place& place : places) names.push_back(place.folder.string());
    for (std::size_t n = 0; n < places.size(); ++n) {
      rows.bind(std::string_view(names[n]));
      if (!places[n].only.empty()) rows.bind(std::string_view(places[n].only));
    }
    for (const auto& value : condition.values)
      if (const auto* number = std::get_if<double>(&value))
        rows.bind(*number);
      else
        rows.bind(std::string_view(std::get<std::string>(value)));
    std::vector<FoundRun> found;
    while (rows.step()) {
      FoundRun run{fs::path(rows.text(0)) / rows.text(1), rows.text(2)};
      if (checksum_of(run.listing) != rows.integer(3)) throw DamagedDatabase("a checksum does not hold");
      for (const Place& place : places)  // as it was asked for
        if (place.folder == fs::path(rows.text(0)) && (place.only.empty() || place.only == rows.text(1))) {
          run.folder = place.only.empty() ? place.given / rows.text(1) : place.given;
          break;
        }
      found.push_back(std::move(run));
    }
    return found;
  }

 private:
  struct Changed {
    fs::path place;
    std::string name;
    std::int64_t state = 0;
  };
  struct Known {
    std::int64_t id = 0, state = 0;
    bool ended = false, running = false;
  };

  fs::path sum_file() const { return file_.string() + ".sum"; }

  // SQLite finds damage of its own structure alone; the sum finds a changed byte of a value too.
  void check_sum() const {
    if (file_.empty() || !fs::exists(sum_file())) return;
    std::istringstream in(read_file(sum_file()));
    FileSum kept;
    if (!(in >> kept.changes >> kept.sum)) return;
    const FileSum now = connection_.sum();
    if (now.changes == kept.changes && now.sum != kept.sum)
      throw DamagedDatabase("its checksum does not hold");
  }
  void keep_sum() const try {
    if (file_.empty()) return;
    const FileSum now = connection_.sum();
    write_file_atomically(sum_file(), std::to_string(now.changes) + " " + std::to_string(now.sum) + "\n");
  } catch (const std::exception&) {  // then the next use does not compare it
  }

  // Compares the rows of a place with its folders.
  void look(const Place& place, std::vector<Changed>& changed, IndexReport& report) {
    std::map<std::string, Known> known;
    const std::string folder = place.folder.string();
    Statement rows(connection_.get(), "SELECT name, id, state, ended, running FROM runs WHERE place = ?");
    rows.bind(std::string_view(folder));
    while (rows.step())
      known[rows.text(0)] = {rows.integer(1), rows.integer(2), rows.integer(3) != 0, rows.integer(4) != 0};
    rows.reset();
    const auto compare = [&](const std::string& name, std::int64_t state) {
      const auto at = known.find(name);
      bool fresh = at != known.end() && at->second.state == state;
      if (!fresh && !is_run(place.folder / name)) return;
      ++report.runs;
      // A print that begins or goes on says so by its lock alone.
      if (fresh && !at->second.ended)
        fresh = !at->second.running && !printing_process(place.folder / name).has_value();
      if (!fresh) changed.push_back({place.folder, name, state});
      if (at != known.end()) known.erase(at);
    };
    if (!place.only.empty()) {
      compare(place.only, run_state(place.folder / place.only));
      return;
    }
    each_run_state(place.folder, compare);
    if (known.empty()) return;
    Transaction transaction(connection_);
    for (const auto& [name, row] : known) {
      forget(row.id);
      ++report.gone;
    }
    transaction.commit();
  }

  void forget(std::int64_t id) {
    for (const char* sql : {"DELETE FROM facts WHERE run = ?", "DELETE FROM texts WHERE run = ?",
                            "DELETE FROM runs WHERE id = ?"})
      Statement(connection_.get(), sql).bind(id).run();
  }

  void keep(const Changed& changed, const RunEntry& entry, const RunFacts& facts) {
    const std::string place = changed.place.string(), listing = run_listing_text(entry);
    Statement old(connection_.get(), "SELECT id FROM runs WHERE place = ? AND name = ?");
    old.bind(std::string_view(place)).bind(std::string_view(changed.name));
    const std::optional<std::int64_t> id = old.step() ? std::optional(old.integer(0)) : std::nullopt;
    old.reset();
    if (id) forget(*id);
    Statement(connection_.get(),
              "INSERT INTO runs(place, name, state, lab, settings, ended, running, listing, checksum) "
              "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(std::string_view(place))
        .bind(std::string_view(changed.name))
        .bind(changed.state)
        .bind(std::string_view(facts.lab))
        .bind(std::int64_t(facts.settings))
        .bind(std::int64_t(facts.ended))
        .bind(std::int64_t(entry.running))
        .bind(std::string_view(listing))
        .bind(checksum_of(listing))
        .run();
    const std::int64_t run = sqlite3_last_insert_rowid(connection_.get());
    Statement fact(connection_.get(), "INSERT INTO facts(run, key, number, word) VALUES(?, ?, ?, ?)");
    for (const Fact& f : facts.facts) {
      fact.bind(run).bind(std::string_view(f.key));
      if (f.number)
        fact.bind(*f.number);
      else
        fact.bind_nothing();
      fact.bind(std::string_view(f.word)).run();
    }
    Statement(connection_.get(), "INSERT INTO texts(run, word) VALUES(?, ?)")
        .bind(run)
        .bind(std::string_view(facts.text))
        .run();
  }

  fs::path file_;
  Connection connection_;
};

RunIndex::RunIndex(fs::path file, std::function<void(const std::string&)> note)
    : file_(std::move(file)), note_(std::move(note)) {
  if (file_.empty()) return;
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  if (!error) return;
  if (note_)
    note_(file_.string() + ": cannot be made (" + error.message() + "); the runs are read this once");
  file_.clear();
}

RunIndex::~RunIndex() = default;

// A damaged index costs the time of reading the folders again.
template <class Work>
auto RunIndex::repaired(Work work) {
  for (bool again = false;;) try {
      if (!database_) database_ = std::make_unique<Database>(file_);
      return work(*database_);
    } catch (const DamagedDatabase& e) {
      database_.reset();
      if (again || file_.empty()) throw std::runtime_error(file_.string() + ": " + e.what());
      again = true;
      if (note_)
        note_(file_.string() + ": the index of runs cannot be used (" + e.what() + "); it is made anew");
      std::error_code ignored;
      fs::remove(file_, ignored);
      fs::remove(file_.string() + "-journal", ignored);
      fs::remove(file_.string() + ".sum", ignored);
    } catch (const UnusableDatabase& e) {
      database_.reset();
      if (file_.empty()) throw std::runtime_error(std::string("the index of runs: ") + e.what());
      if (note_) note_(file_.string() + ": cannot be used (" + e.what() + "); the runs are read this once");
      file_.clear();
    }
}

IndexReport RunIndex::refresh(const std::vector<fs::path>& given, const Progress& progress) {
  std::vector<Place> places;
  for (const fs::path& place : given) places.push_back(place_of_path(place));
  return repaired([&](Database& database) { return database.refresh(places, progress); });
}

std::vector<FoundRun> RunIndex::find(const Query& query, std::string_view text,
                                     const std::vector<fs::path>& given, const FindOptions& options) {
  std::vector<Place> places;
  for (const fs::path& place : given) places.push_back(place_of_path(place));
  if (places.empty()) return {};
  const SqlCondition condition = sql_of(query, text);
  bool first = true;
  return repaired([&](Database& database) {
    if (!first) database.refresh(places, {});  // the index of before was damaged
    first = false;
    return database.find(condition, places, options);
  });
}

fs::path user_index() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return value ? std::string(value) : std::string();
  };
  if (const std::string file = variable("FIRN_INDEX"); !file.empty()) return file;
  const std::string cache = variable("XDG_CACHE_HOME"), home = variable("HOME");
  if (cache.empty() && home.empty()) return {};
  return (cache.empty() ? fs::path(home) / ".cache" : fs::path(cache)) / "firn" / "runs.sqlite";
}

}  // namespace firn::runs
