// FolderSource gives the pictures of a folder, one after the other by name.
#pragma once

#include <filesystem>
#include <string>

#include "runtime/camera/picture_source.h"

namespace firn::camera {

/// Grey PNG files, *.png; a file that comes later is taken if its name follows that of the last one. Settings
/// are accepted and have no effect: the pictures were taken with theirs.
class FolderSource final : public PictureSource {
 public:
  /// @throws std::runtime_error: no folder
  explicit FolderSource(std::filesystem::path folder);
  std::string name() const override { return "folder " + folder_.filename().string(); }
  std::string set_up(const ShotSettings&) override { return {}; }
  /// @throws std::runtime_error: no further picture within a second, a file that is none (named, and passed)
  GreyShot take(const std::function<bool()>& ended) override;

 private:
  std::string next() const;  ///< empty: none

  std::filesystem::path folder_;
  std::string last_;  ///< name of the last picture given
};

}  // namespace firn::camera
