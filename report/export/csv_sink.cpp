// CSV: a file for the values of each table, one for each map (log_event, j, i, x, y, value) and list
// (log_event, index, value), and columns.csv with the unit and the sentence of each column.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

#include "files/record/event_format.h"
#include "files/usage_error.h"
#include "lcmtypes/utf8.h"
#include "report/export/csv_text.h"
#include "report/export/spool.h"
#include "report/export/tables.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;
using schema::Kind;

void append_real(std::string& out, double v, bool single) {
  char text[40];
  if (!std::isfinite(v)) {
    out += std::isnan(v) ? "NaN" : v > 0 ? "inf" : "-inf";
    return;
  }
  const auto r =
      single ? std::to_chars(text, text + sizeof text, float(v)) : std::to_chars(text, text + sizeof text, v);
  out.append(text, r.ptr);
}

void append_whole(std::string& out, std::int64_t v) {
  char text[24];
  out.append(text, std::to_chars(text, text + sizeof text, v).ptr);
}

// One number as LCM encodes it.
void append_number(std::string& out, Kind kind, const std::byte* p) {
  switch (kind) {
    case Kind::kFloat:
      return append_real(out, std::bit_cast<float>(record::big32(p)), true);
    case Kind::kDouble:
      return append_real(out, std::bit_cast<double>(record::big64(p)), false);
    case Kind::kInt64:
      append_whole(out, std::int64_t(record::big64(p)));
      return;
    case Kind::kInt32:
      append_whole(out, std::int32_t(record::big32(p)));
      return;
    case Kind::kInt16:
      append_whole(out, std::int16_t(unsigned(p[0]) << 8 | unsigned(p[1])));
      return;
    case Kind::kByte:
      append_whole(out, unsigned(*p));
      return;
    default:
      append_whole(out, int(std::int8_t(*p)));
  }
}

class CsvSink : public TableSink {
 public:
  explicit CsvSink(const fs::path& folder) : target_(folder), spool_(unfinished(folder)) {
    columns_ = spool_.add("columns.csv");
    spool_.append(columns_, "file,column,unit,values,description\n");
  }

  std::size_t open(const Table& table) override {
    Files& files = tables_.emplace_back();
    files.table = table;
    if (table.grid) write_places(*table.grid, files);
    if (std::ranges::any_of(table.columns, [](const Column& c) { return c.shape == Shape::kOne; }))
      files.values = spool_.add(table.path + ".csv");
    std::string head;
    for (const Column& c : table.columns) {
      std::string file = table.path + ".csv";
      files.own.push_back(0);
      if (c.shape == Shape::kOne) {
        head += (head.empty() ? "" : ",") + c.name;
      } else {
        file = table.path + "." + c.name + ".csv";
        files.own.back() = spool_.add(file);
        spool_.append(files.own.back(), c.shape == Shape::kMap ? "log_event,j,i,x_mm,y_mm," + c.name + "\n"
                                                               : "log_event,index," + c.name + "\n");
      }
      spool_.append(columns_, csv_text(file) + "," + csv_text(c.name) + "," + csv_text(c.unit) + "," +
                                  csv_text(c.values) + "," + csv_text(c.text) + "\n");
    }
    if (files.values > 0) spool_.append(files.values, head + "\n");
    return tables_.size() - 1;
  }

  void row(std::size_t table, std::span<const Cell> cells) override {
    const Files& files = tables_[table];
    std::string line, event;
    if (files.table.columns[0].shape == Shape::kOne && files.table.columns[0].kind != Kind::kString)
      append_number(event, files.table.columns[0].kind, cells[0].numbers.data());
    else
      event = "0";  // a map of the configuration, or texts
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Column& c = files.table.columns[i];
      if (c.shape == Shape::kMap) add_map(files, i, cells[i], event);
      if (c.shape == Shape::kList) add_list(files, i, cells[i], event);
      if (c.shape != Shape::kOne) continue;
      if (i > 0) line += ',';
      append(line, c.kind, cells[i], 0);
    }
    if (files.values > 0) spool_.append(files.values, line + "\n");
  }

  void document(const std::string& path, const std::string& text, std::string_view content) override {
    const std::size_t file = spool_.add(path + ".txt");
    spool_.append(file, content);
    spool_.append(columns_, csv_text(path + ".txt") + ",,text,," + csv_text(text) + "\n");
  }

  void finish() override { spool_.keep_as(target_); }

 private:
  struct Files {
    Table table;
    std::size_t values = 0;                                  // 0: the table has maps and lists alone
    std::vector<std::size_t> own;                            // of maps and lists
    std::vector<std::string> columns_of_grid, rows_of_grid;  // "3,0.25," and "1.5,"
  };
  static constexpr std::size_t kLines_bytes = 1 << 16;

  static void write_places(const GridSpec& grid, Files& files) {
    for (int i = 0; i < grid.nx; ++i) {
      std::string& text = files.columns_of_grid.emplace_back();
      append_whole(text, i);
      text += ',';
      append_real(text, grid.x_mm(i), false);
      text += ',';
    }
    for (int j = 0; j < grid.ny; ++j) {
      std::string& text = files.rows_of_grid.emplace_back();
      append_real(text, grid.y_mm(j), false);
      text += ',';
    }
  }

  static fs::path unfinished(const fs::path& folder) {
    if (fs::exists(folder)) throw UsageError(folder.string() + ": exists; an export makes a new folder");
    return folder.string() + ".part";
  }

  static void append(std::string& out, Kind kind, const Cell& cell, std::size_t k) {
    if (kind == Kind::kString)
      out += csv_text(cell.strings[k]);
    else
      append_number(out, kind, cell.numbers.data() + k * schema::size_of(kind));
  }

  void add_map(const Files& files, std::size_t column, const Cell& cell, const std::string& event) {
    const GridSpec& g = *files.table.grid;
    const Kind kind = files.table.columns[column].kind;
    for (int j = 0; j < g.ny; ++j) {
      begin_ = event + ',';
      append_whole(begin_, j);
      begin_ += ',';
      lines_.clear();
      for (int i = 0; i < g.nx; ++i) {
        lines_ += begin_;
        lines_ += files.columns_of_grid[std::size_t(i)];
        lines_ += files.rows_of_grid[std::size_t(j)];
        append(lines_, kind, cell, g.index(i, j));
        lines_ += '\n';
      }
      spool_.append(files.own[column], lines_);
    }
  }

  void add_list(const Files& files, std::size_t column, const Cell& cell, const std::string& event) {
    const Kind kind = files.table.columns[column].kind;
    const std::size_t n =
        kind == Kind::kString ? cell.strings.size() : cell.numbers.size() / schema::size_of(kind);
    begin_ = event + ',';
    lines_.clear();
    for (std::size_t k = 0; k < n; ++k) {
      lines_ += begin_;
      append_whole(lines_, std::int64_t(k));
      lines_ += ',';
      append(lines_, kind, cell, k);
      lines_ += '\n';
      if (lines_.size() < kLines_bytes && k + 1 < n) continue;
      spool_.append(files.own[column], lines_);
      lines_.clear();
    }
  }

  fs::path target_;
  Spool spool_;
  std::string begin_, lines_;  // storage used again
  std::size_t columns_ = 0;
  std::vector<Files> tables_;
};

}  // namespace

std::string csv_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : valid_utf8(text)) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::unique_ptr<TableSink> csv_sink(const fs::path& folder) { return std::make_unique<CsvSink>(folder); }

}  // namespace firn::report
