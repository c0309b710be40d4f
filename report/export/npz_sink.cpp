// .npz: a .npy array for each column [numpy.lib.format, version 1.0], and columns.csv.
#include <algorithm>
#include <array>
#include <fstream>

#include "files/record/output_target.h"
#include "files/record/part_file.h"
#include "files/text_file.h"
#include "lcmtypes/utf8.h"
#include "report/export/csv_text.h"
#include "report/export/spool.h"
#include "report/export/tables.h"
#include "report/export/zip_file.h"

namespace firn::tables {
namespace {

namespace fs = std::filesystem;
using schema::Kind;

// Numbers stay big endian, as the messages have them.
constexpr std::array<std::string_view, 10> kTypes{">i1", ">i2", ">i4", ">i8", ">u1",
                                                  ">i1", ">f4", ">f8", "",    ""};

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

class NpzSink : public TableSink {
 public:
  explicit NpzSink(const fs::path& file)
      : target_(logfile::output_target(file)),
        part_(target_.string() + ".part"),
        spool_(target_.string() + ".arrays.part") {}
  ~NpzSink() override {
    if (!finished_) part_.remove();
  }

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
    ZipWriter zip(part_.path());
    for (const auto& arrays : tables_)
      for (const Array& a : arrays)
        zip.add(a.name + ".npy", [&](const ZipWriter::Put& put) {
          a.kind == Kind::kString ? put_strings(a, put) : put_numbers(a, put);
        });
    zip.add("columns.csv", [&](const ZipWriter::Put& put) { put(columns_); });
    zip.close();
    std::error_code error;
    fs::rename(part_.path(), target_, error);
    if (error) throw WriteError(target_.string() + ": " + error.message());
    finished_ = true;
  }

 private:
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

  void put_numbers(const Array& a, const ZipWriter::Put& put) const {
    std::string shape = std::to_string(a.values) + ",";
    if (a.shape == Shape::kMap) shape += std::to_string(a.grid.ny) + "," + std::to_string(a.grid.nx);
    put(npy_head(std::string(kTypes[std::size_t(a.kind)]), shape));
    std::ifstream in(spool_.path(a.file), std::ios::binary);
    std::string block(1 << 18, '\0');
    while (in.read(block.data(), std::streamsize(block.size())) || in.gcount() > 0)
      put(std::string_view(block).substr(0, std::size_t(in.gcount())));
  }

  void put_strings(const Array& a, const ZipWriter::Put& put) const {
    put(npy_head("<U" + std::to_string(a.longest), a.single ? "" : std::to_string(a.values) + ","));
    std::ifstream in(spool_.path(a.file), std::ios::binary);
    std::string text;
    for (std::uint64_t n = 0; in.read(reinterpret_cast<char*>(&n), sizeof n);) {
      text.resize(n);
      in.read(text.data(), std::streamsize(n));
      std::u32string wide = code_points(text);
      wide.resize(a.longest, U'\0');
      put({reinterpret_cast<const char*>(wide.data()), wide.size() * 4});
    }
  }

  fs::path target_;
  logfile::PartFile part_;
  Spool spool_;
  std::string columns_ = "array,unit,values,description\n";
  std::vector<std::vector<Array>> tables_;
  bool finished_ = false;
};

}  // namespace

std::unique_ptr<TableSink> npz_sink(const fs::path& file) { return std::make_unique<NpzSink>(file); }

}  // namespace firn::tables
