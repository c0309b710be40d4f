#include "report/export/hdf5_file.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "files/text_file.h"
#include "lcmtypes/utf8.h"

namespace firn::report {
namespace {

constexpr unsigned kTruncate = 2;  // H5F_ACC_TRUNC, whose macro calls the library

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& file, std::filesystem::path target)
    : h_(Hdf5::library()), target_(std::move(target)) {
  text_type_ = checked(h_.H5Tcopy(h_.id("H5T_C_S1_g")), "a type");
  h_.H5Tset_size(text_type_, H5T_VARIABLE);
  h_.H5Tset_cset(text_type_, H5T_CSET_UTF8);
  undated_ = checked(h_.H5Pcreate(h_.id("H5P_CLS_DATASET_CREATE_ID_g")), "a property list");
  h_.H5Pset_obj_track_times(undated_, false);  // the same run gives the same bytes
  groups_ = checked(h_.H5Pcreate(h_.id("H5P_CLS_LINK_CREATE_ID_g")), "a property list");
  h_.H5Pset_create_intermediate_group(groups_, 1);
  errno = 0;
  file_ = checked(h_.H5Fcreate(file.c_str(), kTruncate, H5P_DEFAULT, H5P_DEFAULT), "the file");
}

// The library crashes when it closes a file after a write that failed, as on a full disk: the identifiers
// then end with the program.
Hdf5File::~Hdf5File() {
  if (failed_) return;
  if (file_ >= 0) h_.H5Fclose(file_);
  h_.H5Pclose(groups_);
  h_.H5Pclose(undated_);
  h_.H5Tclose(text_type_);
}

void Hdf5File::fail(const std::string& what) const {
  failed_ = true;
  throw WriteError(target_.string() + ": cannot write " + what +
                   (errno ? std::string(": ") + std::strerror(errno) : ""));
}

void Hdf5File::attribute(hid_t of, const char* name, const std::string& text) const {
  const std::string clean = valid_utf8(text);
  const char* chars = clean.c_str();
  const hid_t space = h_.H5Screate(H5S_SCALAR);
  const hid_t id = checked(h_.H5Acreate2(of, name, text_type_, space, H5P_DEFAULT, H5P_DEFAULT), name);
  checked(h_.H5Awrite(id, text_type_, &chars), name);
  h_.H5Aclose(id);
  h_.H5Sclose(space);
}

void Hdf5File::attribute(hid_t of, const char* name, const std::vector<std::string>& texts) const {
  std::vector<const char*> chars;
  for (const std::string& text : texts) chars.push_back(text.c_str());
  const hsize_t size = texts.size();
  const hid_t space = h_.H5Screate_simple(1, &size, nullptr);
  const hid_t id = checked(h_.H5Acreate2(of, name, text_type_, space, H5P_DEFAULT, H5P_DEFAULT), name);
  checked(h_.H5Awrite(id, text_type_, chars.data()), name);
  h_.H5Aclose(id);
  h_.H5Sclose(space);
}

void Hdf5File::attribute(hid_t of, const char* name, double value) const {
  const hid_t type = h_.id("H5T_NATIVE_DOUBLE_g"), space = h_.H5Screate(H5S_SCALAR);
  const hid_t id =
      checked(h_.H5Acreate2(of, name, h_.id("H5T_IEEE_F64LE_g"), space, H5P_DEFAULT, H5P_DEFAULT), name);
  checked(h_.H5Awrite(id, type, &value), name);
  h_.H5Aclose(id);
  h_.H5Sclose(space);
}

hid_t Hdf5File::group(const std::string& path) const {
  return checked(h_.H5Gcreate2(file_, path.c_str(), groups_, H5P_DEFAULT, H5P_DEFAULT), path);
}

void Hdf5File::text(const std::string& path, const std::string& description, std::string_view content) const {
  const hid_t space = h_.H5Screate(H5S_SCALAR);
  const hid_t id =
      checked(h_.H5Dcreate2(file_, path.c_str(), text_type_, space, groups_, undated_, H5P_DEFAULT), path);
  attribute(id, "units", "text");
  attribute(id, "description", description);
  const std::string clean = valid_utf8(content);
  const char* chars = clean.c_str();
  checked(h_.H5Dwrite(id, text_type_, H5S_ALL, H5S_ALL, H5P_DEFAULT, &chars), path);
  h_.H5Sclose(space);
  h_.H5Dclose(id);
}

void Hdf5File::soft_link(const std::string& from, const std::string& target) const {
  checked(h_.H5Lcreate_soft(target.c_str(), file_, from.c_str(), groups_, H5P_DEFAULT), from);
}

void Hdf5File::make_scale(hid_t dataset, const std::string& name) const {
  checked(h_.H5DSset_scale(dataset, name.c_str()), name);
}

hid_t Hdf5File::bare_scale(const std::string& path, std::uint64_t size,
                           const std::string& description) const {
  const hsize_t extent = size;
  const hid_t space = h_.H5Screate_simple(1, &extent, nullptr);
  const hid_t id = checked(
      h_.H5Dcreate2(file_, path.c_str(), h_.id("H5T_IEEE_F32BE_g"), space, groups_, undated_, H5P_DEFAULT),
      path);
  h_.H5Sclose(space);
  attribute(id, "units", "1");
  attribute(id, "description", description);
  // netCDF-4 knows a dimension without a variable by these words, with the size in ten places.
  std::array<char, 80> name{};
  std::snprintf(name.data(), name.size(), "This is a netCDF dimension but not a netCDF variable.%10llu",
                static_cast<unsigned long long>(size));
  make_scale(id, name.data());
  return id;
}

void Hdf5File::attach(hid_t dataset, unsigned axis, hid_t scale, const std::string& path) const {
  checked(h_.H5DSattach_scale(dataset, scale, axis), path);
}

void Hdf5File::close() { checked(h_.H5Fclose(std::exchange(file_, -1)), "the end of the file"); }

}  // namespace firn::report
