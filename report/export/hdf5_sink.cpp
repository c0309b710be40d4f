// HDF5: a group for each table, a dataset for each column, chunks of one map or of kBuffered values,
// deflated. Types are integers, IEEE floats and UTF-8 strings of variable length, which every reader has.
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "files/record/output_target.h"
#include "files/record/part_file.h"
#include "files/text_file.h"
#include "lcmtypes/utf8.h"
#include "report/export/hdf5_library.h"
#include "report/export/tables.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;
using schema::Kind;

constexpr unsigned kTruncate = 2;     // H5F_ACC_TRUNC, whose macro calls the library
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
      : h_(Hdf5::library()), target_(record::output_target(file)), part_(target_.string() + ".part") {
    text_type_ = checked(h_.H5Tcopy(h_.id("H5T_C_S1_g")), "a type");
    h_.H5Tset_size(text_type_, H5T_VARIABLE);
    h_.H5Tset_cset(text_type_, H5T_CSET_UTF8);
    undated_ = checked(h_.H5Pcreate(h_.id("H5P_CLS_DATASET_CREATE_ID_g")), "a property list");
    h_.H5Pset_obj_track_times(undated_, false);  // the same run gives the same bytes
    groups_ = checked(h_.H5Pcreate(h_.id("H5P_CLS_LINK_CREATE_ID_g")), "a property list");
    h_.H5Pset_create_intermediate_group(groups_, 1);
    errno = 0;
    file_ = checked(h_.H5Fcreate(part_.path().c_str(), kTruncate, H5P_DEFAULT, H5P_DEFAULT), "the file");
  }

  // The library crashes when it closes a file after a write that failed, as on a full disk: the file is
  // removed, and its identifiers end with the program.
  ~Hdf5Sink() override {
    if (!finished_) part_.remove();
    if (failed_) return;
    for (auto& table : tables_)
      for (Dataset& d : table)
        if (d.id >= 0) h_.H5Dclose(d.id);
    if (file_ >= 0) h_.H5Fclose(file_);
    h_.H5Pclose(groups_);
    h_.H5Pclose(undated_);
    h_.H5Tclose(text_type_);
  }

  std::size_t open(const Table& table) override {
    const hid_t group =
        checked(h_.H5Gcreate2(file_, table.path.c_str(), groups_, H5P_DEFAULT, H5P_DEFAULT), table.path);
    attribute(group, "description", table.text);
    h_.H5Gclose(group);
    std::vector<Dataset>& columns = tables_.emplace_back();
    bool maps = false;
    for (const Column& column : table.columns) {
      Dataset& d = columns.emplace_back();
      d.column = column;
      d.path = table.path + "/" + column.name;
      if (column.shape == Shape::kMap) {
        d.grid = table.grid;
        maps = true;
      }
    }
    if (maps) coordinates(table);
    for (const Column& column : table.columns)
      if (column.shape == Shape::kList)
        for (const Column& place : list_columns(column)) {
          Dataset& d = columns.emplace_back();
          d.column = place;
          d.path = table.path + "/" + d.column.name;
        }
    return tables_.size() - 1;
  }

  void row(std::size_t table, std::span<const Cell> cells) override {
    std::vector<Dataset>& columns = tables_[table];
    std::size_t extra = cells.size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      Dataset& d = columns[i];
      const std::uint64_t before = d.written + d.buffered;
      d.column.kind == Kind::kString ? add_strings(d, cells[i].strings) : add(d, cells[i].numbers);
      if (d.column.shape != Shape::kList) continue;
      add_integer(columns[extra++], before);
      add_integer(columns[extra++], d.written + d.buffered - before);
    }
  }

  void document(const std::string& path, const std::string& text, std::string_view content) override {
    Dataset d;
    d.path = path;
    d.column.kind = Kind::kString;
    const hid_t space = h_.H5Screate(H5S_SCALAR);
    d.id =
        checked(h_.H5Dcreate2(file_, path.c_str(), text_type_, space, groups_, undated_, H5P_DEFAULT), path);
    attribute(d.id, "units", "text");
    attribute(d.id, "description", text);
    const std::string clean = valid_utf8(content);
    const char* chars = clean.c_str();
    checked(h_.H5Dwrite(d.id, text_type_, H5S_ALL, H5S_ALL, H5P_DEFAULT, &chars), path);
    h_.H5Sclose(space);
    h_.H5Dclose(d.id);
  }

  void finish() override {
    for (auto& table : tables_)
      for (Dataset& d : table) {
        flush(d, true);
        checked(h_.H5Dclose(std::exchange(d.id, -1)), d.path);
      }
    checked(h_.H5Fclose(std::exchange(file_, -1)), "the end of the file");
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

  template <class Id>
  Id checked(Id id, const std::string& what) const {
    if (id < 0) {
      failed_ = true;
      throw WriteError(target_.string() + ": cannot write " + what +
                       (errno ? std::string(": ") + std::strerror(errno) : ""));
    }
    return id;
  }

  // Of fixed length: strings of variable length would each take a place in a heap of 4096 bytes.
  void attribute(hid_t of, const char* name, const std::string& text) {
    const std::string clean = valid_utf8(text);
    const hid_t space = h_.H5Screate(H5S_SCALAR), type = h_.H5Tcopy(h_.id("H5T_C_S1_g"));
    h_.H5Tset_size(type, clean.size() + 1);
    h_.H5Tset_cset(type, H5T_CSET_UTF8);
    const hid_t id = checked(h_.H5Acreate2(of, name, type, space, H5P_DEFAULT, H5P_DEFAULT), name);
    h_.H5Awrite(id, type, clean.c_str());
    h_.H5Aclose(id);
    h_.H5Tclose(type);
    h_.H5Sclose(space);
  }

  void attribute(hid_t of, const char* name, double value) {
    const hid_t type = h_.id("H5T_NATIVE_DOUBLE_g"), space = h_.H5Screate(H5S_SCALAR);
    const hid_t id =
        checked(h_.H5Acreate2(of, name, h_.id("H5T_IEEE_F64LE_g"), space, H5P_DEFAULT, H5P_DEFAULT), name);
    h_.H5Awrite(id, type, &value);
    h_.H5Aclose(id);
    h_.H5Sclose(space);
  }

  // Positions of the cells' centres.
  void coordinates(const Table& table) {
    const GridSpec& g = *table.grid;
    for (const bool x : {true, false}) {
      std::vector<double> values;
      for (int k = 0; k < (x ? g.nx : g.ny); ++k) values.push_back(x ? g.x_mm(k) : g.y_mm(k));
      const hsize_t size = values.size();
      const hid_t space = h_.H5Screate_simple(1, &size, nullptr);
      const std::string path = table.path + (x ? "/grid_x_mm" : "/grid_y_mm");
      const hid_t id = checked(h_.H5Dcreate2(file_, path.c_str(), h_.id("H5T_IEEE_F64LE_g"), space, groups_,
                                             undated_, H5P_DEFAULT),
                               path);
      attribute(id, "units", "mm");
      attribute(id, "description", x ? "Centres of the cells along x." : "Centres of the cells along y.");
      checked(h_.H5Dwrite(id, h_.id("H5T_NATIVE_DOUBLE_g"), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
              path);
      h_.H5Dclose(id);
      h_.H5Sclose(space);
    }
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
    d.id = checked(h_.H5Dcreate2(file_, d.path.c_str(),
                                 text ? text_type_ : h_.id(kMemberTypes[std::size_t(d.column.kind)].file),
                                 space, groups_, how, access),
                   d.path);
    attribute(d.id, "units", d.column.unit);
    attribute(d.id, "description", d.column.text);
    if (!d.column.values.empty()) attribute(d.id, "values", d.column.values);
    if (d.grid) {
      attribute(d.id, "dimensions", "row, y, x; the row's layer is in the column layer");
      attribute(d.id, "origin_x_mm", d.grid->origin_x_mm);
      attribute(d.id, "origin_y_mm", d.grid->origin_y_mm);
      attribute(d.id, "pitch_x_mm", d.grid->pitch_x_mm);
      attribute(d.id, "pitch_y_mm", d.grid->pitch_y_mm);
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
    if (!d.fixed) checked(h_.H5Dset_extent(d.id, size.data()), d.path);
    const hid_t space = checked(h_.H5Dget_space(d.id), d.path);
    h_.H5Sselect_hyperslab(space, H5S_SELECT_SET, from.data(), nullptr, part.data(), nullptr);
    const hid_t memory = h_.H5Screate_simple(d.grid ? 3 : 1, part.data(), nullptr);
    const hid_t type =
        d.column.kind == Kind::kString ? text_type_ : h_.id(kMemberTypes[std::size_t(d.column.kind)].memory);
    checked(h_.H5Dwrite(d.id, type, memory, space, H5P_DEFAULT, values), d.path);
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

  const Hdf5& h_;
  fs::path target_;
  record::PartFile part_;
  hid_t file_ = -1, text_type_ = -1, groups_ = -1, undated_ = -1;
  std::vector<std::vector<Dataset>> tables_;
  bool finished_ = false;
  mutable bool failed_ = false;  ///< the library could not write
};

}  // namespace

std::unique_ptr<TableSink> hdf5_sink(const fs::path& file) { return std::make_unique<Hdf5Sink>(file); }

}  // namespace firn::report
