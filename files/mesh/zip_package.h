// ZipPackage reads the parts of a ZIP archive in memory, as 3MF files are (ECMA-376 part 2), by libzip.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "files/mesh/mesh_formats.h"

struct zip;

namespace firn::mesh {

class ZipPackage {
 public:
  /// @throws UsageError naming the file: no archive, or a damaged one
  ZipPackage(Bytes bytes, const std::string& name);

  const std::string& name() const { return name_; }
  std::vector<std::string> parts() const;
  /// A part's name counts in any case, with a slash in front or without.
  bool has(std::string_view part) const;
  /// Unpacks a part and passes its bytes to `sink` piece by piece.
  /// @throws UsageError naming file and part: no such part, encrypted, damaged (checksum), or an archive
  /// whose read parts together unpack to more than 64 MiB + 200 times its size
  void read(std::string_view part, const std::function<void(std::string_view)>& sink);

 private:
  struct Close {
    void operator()(zip* archive) const;
  };
  const std::string& name_;
  std::uint64_t limit_, unpacked_ = 0, packed_;
  std::unique_ptr<zip, Close> archive_;
};

}  // namespace firn::mesh
