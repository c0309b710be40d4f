// TableSink receives the data of runs as tables and writes them in one format. A table has a row for each
// message of a channel; a cell is one value, a map or a list.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid/grid.h"
#include "lcmtypes/schema.h"

namespace firn::report {

enum class Shape : std::uint8_t {
  kOne,   ///< one value a row
  kMap,   ///< ny x nx values a row, of the table's grid
  kList,  ///< any number of values a row
};

struct Column {
  std::string name;                         ///< with its unit: "height_mm"
  schema::Kind kind = schema::Kind::kInt8;  ///< no struct
  Shape shape = Shape::kOne;
  std::string unit;    ///< "mm", "1" of a pure number, "text"
  std::string text;    ///< a sentence for people
  std::string values;  ///< names of values: "kPrint = 0, kEnd = 1"; empty: a quantity
};

/// The plot that a viewer of NeXus files shows of a table.
struct DefaultPlot {
  std::string signal;   ///< column: a map, or one value a row
  std::string axis;     ///< column of one value a row, along the rows; empty: their time or number
  bool of_run = false;  ///< may stand for the run as a whole; one of maps is preferred
};

struct Table {
  std::string path;  ///< "maps/HEIGHT_MAP"; groups are the parts before the last one
  std::string text;
  std::vector<Column> columns;
  std::optional<GridSpec> grid;          ///< of all its maps
  std::optional<DefaultPlot> plot = {};  ///< none: not worth one
  std::string time_column = {};          ///< int64 [us] since the start of the run; empty: rows have no time
};

/// A run as a whole; formats without a place for it leave these to the provenance.
struct RunHead {
  std::string prefix;       ///< of its tables, "" or "RUN/"
  std::string title;        ///< the run's name
  std::string started_utc;  ///< "2026-12-01T09:30:00Z"; empty: not told
};

/// Columns that say where each row's values of a list lie among those of all rows: NAME_first and NAME_count.
inline std::array<Column, 2> list_columns(const Column& list) {
  const auto column = [&](const char* end, const char* text) {
    return Column{list.name + end, schema::Kind::kInt64, Shape::kOne, "1", text + list.name, ""};
  };
  auto first = column("_first", "Index in "), count = column("_count", "Number of values in ");
  first.text += " of the first value of this row.";
  count.text += " of this row.";
  return {first, count};
}

/// Values of one column in one row.
struct Cell {
  std::span<const std::byte> numbers;     ///< as LCM encodes them, big endian
  std::vector<std::string_view> strings;  ///< of a column of strings
};

class TableSink {
 public:
  virtual ~TableSink() = default;
  /// Begins a run: the tables that follow are its.
  virtual void begin_run(const RunHead& /*run*/) {}
  /// @param ended_utc time of the last message; empty: not told
  virtual void end_run(const std::string& /*ended_utc*/) {}
  /// @returns the number of the table, from 0
  virtual std::size_t open(const Table& table) = 0;
  /// @param cells one for each column
  virtual void row(std::size_t table, std::span<const Cell> cells) = 0;
  /// Writes a whole text, such as the configuration.
  virtual void document(const std::string& path, const std::string& text, std::string_view content) = 0;
  /// Ends the output, which takes the place of an earlier one of its name. Without this call nothing is left.
  virtual void finish() = 0;
};

/// @throws std::runtime_error naming the file that cannot be written, or the library that is not installed
std::unique_ptr<TableSink> hdf5_sink(const std::filesystem::path& file);
/// A folder of .csv files: one for the values of each table, one for each map or list.
std::unique_ptr<TableSink> csv_sink(const std::filesystem::path& folder);
/// NumPy's .npz: an array for each column; of a list also NAME_first and NAME_count.
std::unique_ptr<TableSink> npz_sink(const std::filesystem::path& file);

}  // namespace firn::report
