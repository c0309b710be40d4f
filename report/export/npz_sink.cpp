// .npz: a .npy array for each column [numpy.lib.format, version 1.0], and columns.csv.
#include <zip.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>

#include "core/options/enumerators.h"
#include "files/record/output_target.h"
#include "files/text_file.h"
#include "lcmtypes/utf8.h"
#include "report/export/csv_text.h"
#include "report/export/spool.h"
#include "report/export/tables.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;
using schema::Kind;

// Numbers stay big endian, as the messages have them.
constexpr std::array<std::string_view, 10> kTypes{">i1", ">i2", ">i4", ">i8", ">u1",
                                                  ">i1", ">f4", ">f8", "",    ""};
static_assert(kTypes.size() == kTableSize<Kind>);

std::u32string code_points(std::string_view utf8) {
  std::u32string out;
  while (!utf8.empty()) {
    const std::size_t n = std::max<std::size_t>(utf8_length(utf8), 1);
    const auto byte = [&](std::size_t k) { return char32_t(static_cast<unsigned char>(utf8[k])); };
    char32_t c = n == 1 ? byte(0) : byte(0) & (0x7fu >> n);
    for (std::size_t k = 1; k < n; ++k) c = c << 6 | (byte(k) & 0x3fu);
    out += c;
    utf8.remove_prefix(n);
  }
  return out;
}

std::string npy_head(const std::string& type, const std::string& shape) {
  std::string dict = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  while ((10 + dict.size() + 1) % 64 != 0) dict += ' ';
  dict += '\n';
  const std::size_t n = dict.size();
  return std::string("\x93NUMPY\x01\0", 8) + char(n & 255) + char(n >> 8) + dict;
}

struct Array {
  std::string name;
  Kind kind = Kind::kInt8;
  Shape shape = Shape::kOne;
  GridSpec grid;
  bool single = false;  ///< no array, one text
  std::size_t file = 0;
  std::uint64_t values = 0;  ///< maps count as one
  std::size_t longest = 1;   ///< code points of a string
};

// Gives libzip an array piece by piece, from the spool: memory does not grow with its length.
class ArrayReader {
 public:
  ArrayReader(const Array& array, fs::path file) : array_(array), file_(std::move(file)) {}

  static zip_int64_t answer(void* reader, void* data, zip_uint64_t size, zip_source_cmd_t command) {
    auto& self = *static_cast<ArrayReader*>(reader);
    switch (command) {
      case ZIP_SOURCE_SUPPORTS:
        return zip_source_make_command_bitmap(ZIP_SOURCE_OPEN, ZIP_SOURCE_READ, ZIP_SOURCE_CLOSE,
                                              ZIP_SOURCE_STAT, ZIP_SOURCE_ERROR, ZIP_SOURCE_FREE, -1);
      case ZIP_SOURCE_OPEN:
        self.in_.open(self.file_, std::ios::binary);
        self.piece_ = self.head();
        return 0;
      case ZIP_SOURCE_READ:
        return zip_int64_t(self.read(static_cast<char*>(data), size));
      case ZIP_SOURCE_CLOSE:
        self.in_.close();
        return 0;
      case ZIP_SOURCE_STAT:
        zip_stat_init(static_cast<zip_stat_t*>(data));
        return sizeof(zip_stat_t);
      case ZIP_SOURCE_ERROR:
        return zip_error_to_data(&self.error_, data, size);
      default:
        return 0;
    }
  }

 private:
  std::string head() const {
    const std::string values = std::to_string(array_.values) + ",";
    if (array_.kind == Kind::kString)
      return npy_head("<U" + std::to_string(array_.longest), array_.single ? "" : values);
    const bool map = array_.shape == Shape::kMap;
    return npy_head(
        std::string(kTypes[std::size_t(array_.kind)]),
        map ? values + std::to_string(array_.grid.ny) + "," + std::to_string(array_.grid.nx) : values);
  }

  std::size_t read(char* to, std::size_t size) {
    if (at_ == piece_.size()) next_piece();
    const std::size_t n = piece_.copy(to, size, at_);
    at_ += n;
    return n;
  }

  // Leaves no piece at the end.
  void next_piece() {
    at_ = 0;
    if (array_.kind != Kind::kString) {
      piece_.resize(1 << 18);
      in_.read(piece_.data(), std::streamsize(piece_.size()));
      return piece_.resize(std::size_t(in_.gcount()));
    }
    piece_.clear();
    std::uint64_t n = 0;
    if (!in_.read(reinterpret_cast<char*>(&n), sizeof n)) return;
    std::string text(n, '\0');
    in_.read(text.data(), std::streamsize(n));
    std::u32string wide = code_points(text);
    wide.resize(array_.longest, U'\0');
    piece_.assign(reinterpret_cast<const char*>(wide.data()), wide.size() * sizeof(char32_t));
  }

  const Array& array_;
  const fs::path file_;
  std::ifstream in_;
  std::string piece_;
  std::size_t at_ = 0;
  zip_error_t error_{};
};

// Date and time are those of the format's first day: the same content gives the same file.
void add_entry(zip_t* zip, const std::string& name, zip_source_t* source) {
  constexpr zip_uint16_t kFirstDay = 0x21;
  constexpr zip_uint32_t kLevel = 4;
  const zip_int64_t entry = zip_file_add(zip, name.c_str(), source, ZIP_FL_ENC_UTF_8);
  if (entry < 0 || zip_set_file_compression(zip, zip_uint64_t(entry), ZIP_CM_DEFLATE, kLevel) != 0 ||
      zip_file_set_dostime(zip, zip_uint64_t(entry), 0, kFirstDay, 0) != 0)
    throw WriteError(name + ": " + zip_strerror(zip));
}

// The spool makes folders of its own, and must not make the one that the user named by mistake.
fs::path in_a_folder(fs::path file) {
  if (file.has_parent_path() && !fs::is_directory(file.parent_path()))
    throw WriteError(file.string() + ": its folder is not there");
  return file;
}

class NpzSink : public TableSink {
 public:
  explicit NpzSink(const fs::path& file)
      : target_(in_a_folder(record::output_target(file))),
        spool_(target_.string() + ".arrays.part"),
        archive_(spool_.add("archive")) {}

  std::size_t open(const Table& table) override {
    std::vector<Array>& arrays = tables_.emplace_back();
    for (const Column& c : table.columns) {
      arrays.push_back(array(table.path, c));
      if (c.shape == Shape::kMap) arrays.back().grid = *table.grid;
    }
    for (const Column& c : table.columns)
      if (c.shape == Shape::kList)
        for (const Column& place : list_columns(c)) arrays.push_back(array(table.path, place));
    return tables_.size() - 1;
  }

  void row(std::size_t table, std::span<const Cell> cells) override {
    std::vector<Array>& arrays = tables_[table];
    std::size_t extra = cells.size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      Array& a = arrays[i];
      const std::uint64_t before = a.values;
      add(a, cells[i]);
      if (a.shape != Shape::kList) continue;
      add_integer(arrays[extra++], before);
      add_integer(arrays[extra++], a.values - before);
    }
  }

  void document(const std::string& path, const std::string& text, std::string_view content) override {
    Array a;
    a.name = path;
    a.kind = Kind::kString;
    a.single = true;
    a.file = spool_.add(path);
    describe(a.name, "text", "", text);
    add(a, Cell{{}, {content}});
    tables_.push_back({a});
  }

  void finish() override {
    spool_.flush();
    std::vector<std::unique_ptr<ArrayReader>> readers;
    std::unique_ptr<zip_t, decltype(&zip_discard)> archive(
        zip_open(spool_.path(archive_).c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr), &zip_discard);
    if (!archive) throw WriteError(target_.string() + ": cannot be written");
    zip_t* zip = archive.get();
    for (const auto& arrays : tables_)
      for (const Array& a : arrays) {
        readers.push_back(std::make_unique<ArrayReader>(a, spool_.path(a.file)));
        add_entry(zip, a.name + ".npy", zip_source_function(zip, &ArrayReader::answer, readers.back().get()));
      }
    add_entry(zip, "columns.csv", zip_source_buffer(zip, columns_.data(), columns_.size(), 0));
    if (zip_close(zip) != 0) throw WriteError(target_.string() + ": " + zip_strerror(zip));
    static_cast<void>(archive.release());  // closed
    std::error_code error;
    fs::rename(spool_.path(archive_), target_, error);
    if (error) throw WriteError(target_.string() + ": " + error.message());
  }

 private:
  void describe(const std::string& name, const std::string& unit, const std::string& values,
                const std::string& text) {
    columns_ += csv_text(name) + "," + csv_text(unit) + "," + csv_text(values) + "," + csv_text(text) + "\n";
  }

  Array array(const std::string& path, const Column& c) {
    Array a;
    a.name = path + "/" + c.name;
    a.kind = c.kind;
    a.shape = c.shape;
    a.file = spool_.add(a.name);
    describe(a.name, c.unit, c.values, c.text);
    return a;
  }

  void add(Array& a, const Cell& cell) {
    if (a.kind != Kind::kString) {
      spool_.append(a.file, {reinterpret_cast<const char*>(cell.numbers.data()), cell.numbers.size()});
      a.values += a.shape == Shape::kMap ? 1 : cell.numbers.size() / schema::size_of(a.kind);
      return;
    }
    for (const std::string_view s : cell.strings) {  // each behind its length
      const std::string clean = valid_utf8(s);
      const std::uint64_t n = clean.size();
      spool_.append(a.file, {reinterpret_cast<const char*>(&n), sizeof n});
      spool_.append(a.file, clean);
      a.longest = std::max(a.longest, code_points(clean).size());
      ++a.values;
    }
  }

  void add_integer(Array& a, std::uint64_t value) {
    std::array<std::byte, 8> bytes;
    for (int k = 0; k < 8; ++k) bytes[std::size_t(k)] = std::byte(value >> (56 - 8 * k));
    add(a, Cell{bytes, {}});
  }

  fs::path target_;
  Spool spool_;
  std::size_t archive_;  // of the spool's files
  std::string columns_ = "array,unit,values,description\n";
  std::vector<std::vector<Array>> tables_;
};

}  // namespace

std::unique_ptr<TableSink> npz_sink(const fs::path& file) { return std::make_unique<NpzSink>(file); }

}  // namespace firn::report
