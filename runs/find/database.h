// Database holds a connection to SQLite. https://www.sqlite.org/c3ref/intro.html
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace firn::runs {

/// The file is no database, or is damaged.
struct DamagedDatabase : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The file cannot be opened or written.
struct UnusableDatabase : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Statement {
 public:
  /// @throws DamagedDatabase, UnusableDatabase; std::runtime_error with SQLite's reason
  Statement(sqlite3* database, const std::string& sql);
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// Binds the values of the next ?; the text must live until reset().
  Statement& bind(std::int64_t value);
  Statement& bind(double value);
  Statement& bind(std::string_view value);
  Statement& bind_nothing();
  /// Returns true if there is a row. @throws as the constructor
  bool step();
  /// Carries the statement out and makes it ready for other values.
  void run();
  void reset();

  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  std::string text(int column) const;

 private:
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
  int next_ = 1;
};

/// Identifies the content of a database file at one moment.
struct FileSum {
  std::uint32_t changes = 0;  ///< SQLite's count of transactions
  std::uint64_t sum = 0;      ///< XXH64 of all bytes
};

class Connection {
 public:
  /// @param file empty: in memory. @throws as Statement
  explicit Connection(const std::filesystem::path& file);
  ~Connection() { sqlite3_close(database_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  sqlite3* get() const { return database_; }
  void carry_out(const std::string& sql) const;
  /// Reads the file while no other process can write it; through SQLite, as a second descriptor would give up
  /// its locks when it is closed. @throws as Statement
  FileSum sum() const;

 private:
  sqlite3* database_ = nullptr;
};

/// A transaction that other writers wait for; taken back without commit().
class Transaction {
 public:
  explicit Transaction(const Connection& connection) : connection_(connection) {
    connection_.carry_out("BEGIN IMMEDIATE");
  }
  ~Transaction() {
    if (open_) sqlite3_exec(connection_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit() {
    connection_.carry_out("COMMIT");
    open_ = false;
  }

 private:
  const Connection& connection_;
  bool open_ = true;
};

}  // namespace firn::runs
