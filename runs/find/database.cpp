#include "runs/find/database.h"

#include <algorithm>
#include <span>
#include <vector>

#include "files/record/checksum.h"
#include "files/record/event_format.h"

namespace firn::runs {
namespace {

constexpr int kWait_ms = 60'000;  // for another process that writes

[[noreturn]] void fail_of_sqlite(sqlite3* database, int code) {
  const std::string reason = database ? sqlite3_errmsg(database) : sqlite3_errstr(code);
  const int kind = code & 0xff;
  if (kind == SQLITE_CORRUPT || kind == SQLITE_NOTADB || kind == SQLITE_SCHEMA || kind == SQLITE_ERROR ||
      kind == SQLITE_FORMAT)
    throw DamagedDatabase(reason);
  if (kind == SQLITE_READONLY || kind == SQLITE_CANTOPEN || kind == SQLITE_PERM || kind == SQLITE_IOERR ||
      kind == SQLITE_FULL)
    throw UnusableDatabase(reason);
  throw std::runtime_error("the index of runs: " + reason);
}

}  // namespace

Statement::Statement(sqlite3* database, const std::string& sql) : database_(database) {
  const int code = sqlite3_prepare_v2(database, sql.c_str(), int(sql.size()), &statement_, nullptr);
  if (code != SQLITE_OK) fail_of_sqlite(database, code);
}

Statement& Statement::bind(std::int64_t value) {
  sqlite3_bind_int64(statement_, next_++, value);
  return *this;
}
Statement& Statement::bind(double value) {
  sqlite3_bind_double(statement_, next_++, value);
  return *this;
}
Statement& Statement::bind(std::string_view value) {
  sqlite3_bind_text(statement_, next_++, value.data(), int(value.size()), SQLITE_STATIC);
  return *this;
}
Statement& Statement::bind_nothing() {
  sqlite3_bind_null(statement_, next_++);
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) fail_of_sqlite(database_, code);
  return code == SQLITE_ROW;
}

void Statement::run() {
  step();
  reset();
}

void Statement::reset() {
  sqlite3_reset(statement_);
  next_ = 1;
}

std::string Statement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_, column);
  return text ? std::string(reinterpret_cast<const char*>(text),
                            std::size_t(sqlite3_column_bytes(statement_, column)))
              : std::string();
}

Connection::Connection(const std::filesystem::path& file) {
  const int code =
      sqlite3_open_v2(file.empty() ? ":memory:" : file.c_str(), &database_,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX, nullptr);
  if (code != SQLITE_OK) {
    const std::string reason = database_ ? sqlite3_errmsg(database_) : sqlite3_errstr(code);
    sqlite3_close(database_);
    throw UnusableDatabase(reason);
  }
  sqlite3_busy_timeout(database_, kWait_ms);
}

FileSum Connection::sum() const {
  constexpr sqlite3_int64 kBlock = 1 << 20;
  constexpr std::size_t kChanges = 24;  // in the head of the file: https://www.sqlite.org/fileformat.html
  carry_out("BEGIN; SELECT count(*) FROM sqlite_master");  // the transaction keeps writers out
  FileSum s;
  sqlite3_file* file = nullptr;
  sqlite3_int64 size = 0;
  sqlite3_file_control(database_, "main", SQLITE_FCNTL_FILE_POINTER, &file);
  bool read = file && file->pMethods && file->pMethods->xFileSize(file, &size) == SQLITE_OK;
  record::Checksum64 checksum;
  std::vector<std::byte> block(kBlock);
  for (sqlite3_int64 at = 0; read && at < size; at += kBlock) {
    const int n = int(std::min(kBlock, size - at));
    read = file->pMethods->xRead(file, block.data(), n, at) == SQLITE_OK;
    checksum.add(std::span(block).first(std::size_t(n)));
    if (at == 0 && std::size_t(n) >= kChanges + 4) s.changes = record::big32(block.data() + kChanges);
  }
  s.sum = checksum.value();
  carry_out("COMMIT");
  if (!read) throw UnusableDatabase("cannot be read");
  return s;
}

void Connection::carry_out(const std::string& sql) const {
  const int code = sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail_of_sqlite(database_, code);
}

}  // namespace firn::runs
