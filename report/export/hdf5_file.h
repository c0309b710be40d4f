// Hdf5File holds an HDF5 file that is being written, with its attributes, texts and dimension scales as other
// programs look for them: strings of variable length in UTF-8, scales of the HDF5 Dimension Scales
// Specification, which netCDF-4 and xarray take for named dimensions, and groups of NeXus.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "report/export/hdf5_library.h"

namespace firn::report {

class Hdf5File {
 public:
  /// @param target is named in errors @throws WriteError, std::runtime_error naming a package that lacks
  Hdf5File(const std::filesystem::path& file, std::filesystem::path target);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  const Hdf5& library() const { return h_; }
  hid_t id() const { return file_; }
  hid_t text_type() const { return text_type_; }
  hid_t intermediate_groups() const { return groups_; }  ///< property list: makes the groups above an object
  hid_t undated() const { return undated_; }             ///< property list: a dataset without a time

  /// Returns `id`. @throws WriteError naming the file and `what` if it is negative, after which the library
  /// must not close the file: it would crash
  template <class Id>
  Id checked(Id id, const std::string& what) const {
    if (id < 0) fail(what);
    return id;
  }
  bool failed() const { return failed_; }

  void attribute(hid_t of, const char* name, const std::string& text) const;
  void attribute(hid_t of, const char* name, const std::vector<std::string>& texts) const;
  void attribute(hid_t of, const char* name, double value) const;

  /// Makes a group, with those above it. @returns it, to be closed by H5Gclose
  hid_t group(const std::string& path) const;
  /// A text as a dataset of its own.
  void text(const std::string& path, const std::string& description, std::string_view content) const;
  void soft_link(const std::string& from, const std::string& target) const;

  /// Makes a dataset the coordinate of a dimension that bears its name.
  void make_scale(hid_t dataset, const std::string& name) const;
  /// Makes a dimension without coordinates, as netCDF-4 does: a dataset that takes no space. @returns it, to
  /// be closed by H5Dclose
  hid_t bare_scale(const std::string& path, std::uint64_t size, const std::string& description) const;
  void attach(hid_t dataset, unsigned axis, hid_t scale, const std::string& path) const;

  void close();  ///< @throws WriteError

 private:
  [[noreturn]] void fail(const std::string& what) const;

  const Hdf5& h_;
  std::filesystem::path target_;
  hid_t file_ = -1, text_type_ = -1, groups_ = -1, undated_ = -1;
  mutable bool failed_ = false;
};

}  // namespace firn::report
