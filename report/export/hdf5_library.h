// Hdf5 holds the functions of the HDF5 C library and of its dimension scales, which are loaded where they are
// used first: no other command pays for them or needs them. https://docs.hdfgroup.org/hdf5/v1_10/_r_m.html
#pragma once

#include <hdf5.h>
#include <hdf5_hl.h>

namespace firn::report {

struct Hdf5 {
  /// @throws std::runtime_error naming the package that is not installed
  static const Hdf5& library();

  /// Returns a type or class of property lists that the library keeps in a variable: "H5T_STD_I8LE_g".
  hid_t id(const char* variable) const;

 private:
  Hdf5();
  static void* open(const char* name, const char* package);
  static void* symbol(void* library, const char* name);

  void* library_;
  void* scales_;

 public:
#define FIRN_HDF5(name) decltype(&::name) name = reinterpret_cast<decltype(&::name)>(symbol(library_, #name))
  FIRN_HDF5(H5open);
  FIRN_HDF5(H5Fcreate);
  FIRN_HDF5(H5Fclose);
  FIRN_HDF5(H5Gcreate2);
  FIRN_HDF5(H5Gopen2);
  FIRN_HDF5(H5Gclose);
  FIRN_HDF5(H5Screate);
  FIRN_HDF5(H5Screate_simple);
  FIRN_HDF5(H5Sselect_hyperslab);
  FIRN_HDF5(H5Sclose);
  FIRN_HDF5(H5Pcreate);
  FIRN_HDF5(H5Pclose);
  FIRN_HDF5(H5Pset_chunk);
  FIRN_HDF5(H5Pset_deflate);
  FIRN_HDF5(H5Pset_shuffle);
  FIRN_HDF5(H5Pset_obj_track_times);
  FIRN_HDF5(H5Pset_create_intermediate_group);
  FIRN_HDF5(H5Pset_chunk_cache);
  FIRN_HDF5(H5Lcreate_soft);
  FIRN_HDF5(H5Dcreate2);
  FIRN_HDF5(H5Dwrite);
  FIRN_HDF5(H5Dset_extent);
  FIRN_HDF5(H5Dget_space);
  FIRN_HDF5(H5dont_atexit);
  FIRN_HDF5(H5Dclose);
  FIRN_HDF5(H5Acreate2);
  FIRN_HDF5(H5Awrite);
  FIRN_HDF5(H5Aclose);
  FIRN_HDF5(H5Tcopy);
  FIRN_HDF5(H5Tset_size);
  FIRN_HDF5(H5Tset_cset);
  FIRN_HDF5(H5Tclose);
  FIRN_HDF5(H5Eset_auto2);
#undef FIRN_HDF5
#define FIRN_HDF5(name) decltype(&::name) name = reinterpret_cast<decltype(&::name)>(symbol(scales_, #name))
  FIRN_HDF5(H5DSset_scale);
  FIRN_HDF5(H5DSattach_scale);
#undef FIRN_HDF5
};

}  // namespace firn::report
