// HDF5: a group for each table, a dataset for each column, chunks of one map or of kBuffered values,
// deflated. Types are integers, IEEE floats and UTF-8 strings of variable length, which every reader has.
// Each axis of each dataset has a dimension scale: rows their time, maps their positions, lists a bare
// length. Conventions: CF 1.8 (time, contiguous ragged arrays), NeXus (NXentry, NXdata).
#include <array>
#include <cerrno>
#include <utility>

#include "files/record/output_target.h"
#include "files/record/part_file.h"
#include "files/text_file.h"
#include "lcmtypes/utf8.h"
#include "report/export/hdf5_file.h"
#include "report/export/tables.h"
#include "runtime/build_info.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;
using schema::Kind;

constexpr hsize_t kBuffered = 16384;  // values of one column
constexpr hsize_t kSmall_bytes = 4096;
constexpr hsize_t kBufferedStrings = 1024;
constexpr unsigned kDeflateLevel = 4;  // of deflate; 9 takes twice as long for 2 % less

struct Names {
  const char* file;    // little endian
  const char* memory;  // big endian, as LCM encodes
};
constexpr std::array<Names, 9> kMemberTypes{{{"H5T_STD_I8LE_g", "H5T_STD_I8BE_g"},
                                             {"H5T_STD_I16LE_g", "H5T_STD_I16BE_g"},
                                             {"H5T_STD_I32LE_g", "H5T_STD_I32BE_g"},
                                             {"H5T_STD_I64LE_g", "H5T_STD_I64BE_g"},
                                             {"H5T_STD_U8LE_g", "H5T_STD_U8BE_g"},
                                             {"H5T_STD_I8LE_g", "H5T_STD_I8BE_g"},
                                             {"H5T_IEEE_F32LE_g", "H5T_IEEE_F32BE_g"},
                                             {"H5T_IEEE_F64LE_g", "H5T_IEEE_F64BE_g"},
                                             {"", ""}}};
static_assert(kMemberTypes.size() == std::size_t(Kind::kString) + 1, "a column is no struct");

class Hdf5Sink : public TableSink {
 public:
  explicit Hdf5Sink(const fs::path& file)
      : target_(record::output_target(file)),
        part_(target_.string() + ".part"),
        file_(part_.path(), target_),
        h_(file_.library()) {
    const hid_t root = file_.checked(h_.H5Gopen2(file_.id(), "/", H5P_DEFAULT), "the root");
    file_.attribute(root, "NX_class", "NXroot");
    file_.attribute(root, "Conventions", "CF-1.8");
    file_.attribute(root, "creator", "firn");
    file_.attribute(root, "creator_version", build_version());
    h_.H5Gclose(root);
  }

  ~Hdf5Sink() override {
    if (!finished_) part_.remove();
    if (file_.failed()) return;
    for (OpenTable& table : tables_) close(table);
  }

  void begin_run(const RunHead& run) override {
    run_ = run;
    entry_ = run.prefix.empty() ? "entry" : run.prefix.substr(0, run.prefix.size() - 1);
    const hid_t group = file_.group(entry_);
    file_.attribute(group, "NX_class", "NXentry");
    h_.H5Gclose(group);
    file_.text(entry_ + "/title", "Name of the run.", run.title);
    if (!run.started_utc.empty())
      file_.text(entry_ + "/start_time", "When the print began, UTC, ISO 8601.", run.started_utc);
    shown_.reset();
  }

  void end_run(const std::string& ended_utc) override {
    if (!ended_utc.empty())
      file_.text(entry_ + "/end_time", "When the last message was sent, by the print's clock, UTC, ISO 8601.",
                 ended_utc);
    if (!shown_) return;
    file_.soft_link(entry_ + "/plot", "/" + tables_[*shown_].table.path);
    const hid_t group = file_.checked(h_.H5Gopen2(file_.id(), entry_.c_str(), H5P_DEFAULT), entry_);
    file_.attribute(group, "default", "plot");
    h_.H5Gclose(group);
    if (std::exchange(has_default_, true)) return;  // of several runs the first one
    const hid_t root = file_.checked(h_.H5Gopen2(file_.id(), "/", H5P_DEFAULT), "the root");
    file_.attribute(root, "default", entry_);
    h_.H5Gclose(root);
  }

  std::size_t open(const Table& table) override {
    const hid_t group = file_.group(table.path);
    file_.attribute(group, "description", table.text);
    if (table.plot) plot(group, table);
    h_.H5Gclose(group);
    OpenTable& opened = tables_.emplace_back();
    opened.table = table;
    bool maps = false;
    for (const Column& column : table.columns) {
      Dataset& d = opened.columns.emplace_back();
      d.column = column;
      d.path = table.path + "/" + column.name;
      if (column.shape == Shape::kMap) {
        d.grid = table.grid;
        maps = true;
      }
    }
    if (maps)
      for (const bool x : {true, false}) (x ? opened.grid_x : opened.grid_y) = positions(table, x);
    for (const Column& column : table.columns)
      if (column.shape == Shape::kList)
        for (const Column& place : list_columns(column)) {
          Dataset& d = opened.columns.emplace_back();
          d.column = place;
          d.path = table.path + "/" + d.column.name;
        }
    opened.rows.column = row_column(table);
    opened.rows.path = table.path + "/" + opened.rows.column.name;
    return tables_.size() - 1;
  }

  void row(std::size_t table, std::span<const Cell> cells) override {
    OpenTable& opened = tables_[table];
    std::vector<Dataset>& columns = opened.columns;
    std::size_t extra = cells.size();
    if (opened.table.time_column.empty()) add_integer(opened.rows, opened.count);
    ++opened.count;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      Dataset& d = columns[i];
      const std::uint64_t before = d.written + d.buffered;
      d.column.kind == Kind::kString ? add_strings(d, cells[i].strings) : add(d, cells[i].numbers);
      if (!opened.table.time_column.empty() && d.column.name == opened.table.time_column)
        add(opened.rows, cells[i].numbers);
      if (d.column.shape != Shape::kList) continue;
      add_integer(columns[extra++], before);
      add_integer(columns[extra++], d.written + d.buffered - before);
    }
  }

  void document(const std::string& path, const std::string& text, std::string_view content) override {
    file_.text(path, text, content);
  }

  void finish() override {
    for (OpenTable& table : tables_) {
      for (Dataset& d : table.columns) flush(d, true);
      flush(table.rows, true);
      name_axes(table);
      close(table);
    }
    file_.close();
    std::error_code error;
    fs::rename(part_.path(), target_, error);
    if (error) throw WriteError(target_.string() + ": " + error.message());
    finished_ = true;
  }

 private:
  struct Dataset {
    Column column;
    std::string path;
    std::optional<GridSpec> grid;
    hid_t id = -1;
    bool fixed = false;          // written once, of its size
    std::uint64_t written = 0;   // values, or maps, in the file
    std::uint64_t buffered = 0;  // values
    std::vector<std::byte> numbers;
    std::vector<std::string> strings;
  };
  struct OpenTable {
    Table table;
    std::vector<Dataset> columns;
    Dataset rows;  // the scale along the rows: their time, or their number
    std::uint64_t count = 0;
    hid_t grid_x = -1, grid_y = -1;
  };

  void close(OpenTable& table) {
    for (Dataset& d : table.columns)
      if (d.id >= 0) h_.H5Dclose(std::exchange(d.id, -1));
    for (hid_t* id : {&table.rows.id, &table.grid_x, &table.grid_y})
      if (*id >= 0) h_.H5Dclose(std::exchange(*id, -1));
  }

  Column row_column(const Table& table) const {
    if (table.time_column.empty())
      return {"row", Kind::kInt64, Shape::kOne, "1", "Number of the row, from 0.", ""};
    // CF 1.8, section 4.4; a run of unknown start has a time without an epoch.
    return {"time",
            Kind::kInt64,
            Shape::kOne,
            run_.started_utc.empty() ? "us" : "microseconds since " + run_.started_utc,
            "Time of the row by the print's clock.",
            ""};
  }

  /// NXdata: signal over layer, y and x, or over the layers alone.
  void plot(hid_t group, const Table& table) {
    const DefaultPlot& p = *table.plot;
    std::vector<std::string> axes{p.axis.empty() ? row_column(table).name : p.axis};
    if (table.grid) axes.insert(axes.end(), {"grid_y_mm", "grid_x_mm"});
    file_.attribute(group, "NX_class", "NXdata");
    file_.attribute(group, "signal", p.signal);
    file_.attribute(group, "axes", axes);
    if (p.of_run && (!shown_ || (table.grid && !tables_[*shown_].table.grid))) shown_ = tables_.size();
  }

  // Positions of the cells' centres.
  hid_t positions(const Table& table, bool x) {
    const GridSpec& g = *table.grid;
    std::vector<double> values;
    for (int k = 0; k < (x ? g.nx : g.ny); ++k) values.push_back(x ? g.x_mm(k) : g.y_mm(k));
    const hsize_t size = values.size();
    const hid_t space = h_.H5Screate_simple(1, &size, nullptr);
    const std::string name = x ? "grid_x_mm" : "grid_y_mm", path = table.path + "/" + name;
    const hid_t id = file_.checked(h_.H5Dcreate2(file_.id(), path.c_str(), h_.id("H5T_IEEE_F64LE_g"), space,
                                                 file_.intermediate_groups(), file_.undated(), H5P_DEFAULT),
                                   path);
    file_.attribute(id, "units", "mm");
    file_.attribute(id, "description", x ? "Centres of the cells along x." : "Centres of the cells along y.");
    file_.checked(h_.H5Dwrite(id, h_.id("H5T_NATIVE_DOUBLE_g"), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
                  path);
    h_.H5Sclose(space);
    file_.make_scale(id, name);
    return id;
  }

  void name_axes(OpenTable& table) {
    file_.make_scale(table.rows.id, table.rows.column.name);
    for (Dataset& d : table.columns) {
      if (d.column.shape == Shape::kList) {
        const std::string name = d.column.name + "_value";
        const hid_t values = file_.bare_scale(table.table.path + "/" + name, d.written,
                                              "Length of " + d.column.name + ": the values of all rows.");
        file_.attach(d.id, 0, values, d.path);
        h_.H5Dclose(values);
        continue;
      }
      file_.attach(d.id, 0, table.rows.id, d.path);
      if (!d.grid) continue;
      file_.attach(d.id, 1, table.grid_y, d.path);
      file_.attach(d.id, 2, table.grid_x, d.path);
      if (table.table.plot && !table.table.plot->axis.empty())
        file_.attribute(d.id, "coordinates", table.table.plot->axis);  // CF 1.8, section 5
    }
    for (const Column& list : table.table.columns)
      if (list.shape == Shape::kList)
        for (Dataset& d : table.columns)
          if (d.column.name == list_columns(list)[1].name)  // CF 1.8, section 9.3.3
            file_.attribute(d.id, "sample_dimension", list.name + "_value");
  }

  // A column of few values is written once: in one chunk of its size, and without a chunk, whose index alone
  // takes two kilobytes, where it is smaller than that.
  void create(Dataset& d, bool last) {
    std::array<hsize_t, 3> size{0, 0, 0}, most{H5S_UNLIMITED, 0, 0},
        chunk{std::max<hsize_t>(d.buffered, 1), 0, 0};
    int rank = 1;
    if (d.grid) {
      rank = 3;
      size[1] = most[1] = chunk[1] = hsize_t(d.grid->ny);
      size[2] = most[2] = chunk[2] = hsize_t(d.grid->nx);
      chunk[0] = 1;
    }
    const bool text = d.column.kind == Kind::kString;
    d.fixed = last && !d.grid && d.buffered * (text ? 16 : schema::size_of(d.column.kind)) <= kSmall_bytes;
    if (d.fixed) size[0] = most[0] = d.buffered;
    const hid_t space = h_.H5Screate_simple(rank, size.data(), most.data());
    const hid_t how = h_.H5Pcreate(h_.id("H5P_CLS_DATASET_CREATE_ID_g"));
    if (!d.fixed) h_.H5Pset_chunk(how, rank, chunk.data());
    h_.H5Pset_obj_track_times(how, false);
    if (!text && !d.fixed) {  // the characters lie outside the chunks
      h_.H5Pset_shuffle(how);
      h_.H5Pset_deflate(how, kDeflateLevel);
    }
    const hid_t access = h_.H5Pcreate(h_.id("H5P_CLS_DATASET_ACCESS_ID_g"));
    h_.H5Pset_chunk_cache(access, 3, 0, 1.0);  // chunks are written whole
    d.id = file_.checked(
        h_.H5Dcreate2(file_.id(), d.path.c_str(),
                      text ? file_.text_type() : h_.id(kMemberTypes[std::size_t(d.column.kind)].file), space,
                      file_.intermediate_groups(), how, access),
        d.path);
    file_.attribute(d.id, "units", d.column.unit);
    file_.attribute(d.id, "description", d.column.text);
    if (!d.column.values.empty()) file_.attribute(d.id, "values", d.column.values);
    if (d.grid) {
      file_.attribute(d.id, "dimensions", "row, y, x; the row's layer is in the column layer");
      file_.attribute(d.id, "origin_x_mm", d.grid->origin_x_mm);
      file_.attribute(d.id, "origin_y_mm", d.grid->origin_y_mm);
      file_.attribute(d.id, "pitch_x_mm", d.grid->pitch_x_mm);
      file_.attribute(d.id, "pitch_y_mm", d.grid->pitch_y_mm);
    }
    h_.H5Pclose(access);
    h_.H5Pclose(how);
    h_.H5Sclose(space);
  }

  void write(Dataset& d, const void* values, std::uint64_t count) {
    std::array<hsize_t, 3> size{d.written + count, 0, 0}, from{d.written, 0, 0}, part{count, 0, 0};
    if (d.grid) {
      size[1] = part[1] = hsize_t(d.grid->ny);
      size[2] = part[2] = hsize_t(d.grid->nx);
    }
    errno = 0;
    if (!d.fixed) file_.checked(h_.H5Dset_extent(d.id, size.data()), d.path);
    const hid_t space = file_.checked(h_.H5Dget_space(d.id), d.path);
    h_.H5Sselect_hyperslab(space, H5S_SELECT_SET, from.data(), nullptr, part.data(), nullptr);
    const hid_t memory = h_.H5Screate_simple(d.grid ? 3 : 1, part.data(), nullptr);
    const hid_t type = d.column.kind == Kind::kString
                           ? file_.text_type()
                           : h_.id(kMemberTypes[std::size_t(d.column.kind)].memory);
    file_.checked(h_.H5Dwrite(d.id, type, memory, space, H5P_DEFAULT, values), d.path);
    h_.H5Sclose(memory);
    h_.H5Sclose(space);
    d.written += count;
  }

  void flush(Dataset& d, bool last = false) {
    if (d.id < 0) create(d, last);
    if (d.buffered == 0) return;
    if (d.column.kind == Kind::kString) {
      std::vector<const char*> pointers;
      for (const std::string& s : d.strings) pointers.push_back(s.c_str());
      write(d, pointers.data(), d.buffered);
      d.strings.clear();
    } else {
      write(d, d.numbers.data(), d.buffered);
      d.numbers.clear();
    }
    d.buffered = 0;
  }

  void add(Dataset& d, std::span<const std::byte> values) {
    if (d.grid) {
      if (d.id < 0) create(d, false);
      write(d, values.data(), 1);
      return;
    }
    const std::size_t size = schema::size_of(d.column.kind);
    while (!values.empty()) {
      const std::size_t n = std::min<std::size_t>(values.size() / size, kBuffered - d.buffered);
      d.numbers.insert(d.numbers.end(), values.begin(), values.begin() + std::ptrdiff_t(n * size));
      values = values.subspan(n * size);
      d.buffered += n;
      if (d.buffered == kBuffered) flush(d);
    }
  }

  void add_integer(Dataset& d, std::uint64_t value) {
    std::array<std::byte, 8> bytes;
    for (int k = 0; k < 8; ++k) bytes[std::size_t(k)] = std::byte(value >> (56 - 8 * k));
    add(d, bytes);
  }

  void add_strings(Dataset& d, const std::vector<std::string_view>& strings) {
    for (const std::string_view s : strings) {
      d.strings.push_back(valid_utf8(s));
      if (++d.buffered == kBufferedStrings) flush(d);
    }
  }

  fs::path target_;
  record::PartFile part_;
  Hdf5File file_;
  const Hdf5& h_;
  RunHead run_;
  std::string entry_;                 // group of the run that is written
  std::optional<std::size_t> shown_;  // table that is plotted for it
  bool has_default_ = false;
  std::vector<OpenTable> tables_;
  bool finished_ = false;
};

}  // namespace

std::unique_ptr<TableSink> hdf5_sink(const fs::path& file) { return std::make_unique<Hdf5Sink>(file); }

}  // namespace firn::report
