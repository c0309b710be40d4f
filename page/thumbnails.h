// Thumbnails keeps the small pictures of runs, each until its run changes, within a bound of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>

namespace firn::page {

class Thumbnails {
 public:
  /// Returns the bytes of a run's picture; empty: it has none.
  using Draw = std::function<std::string(const std::filesystem::path& run)>;
  static constexpr std::size_t kMostBytes = std::size_t(8) << 20;

  explicit Thumbnails(Draw draw, std::size_t most_bytes = kMostBytes)
      : draw_(std::move(draw)), most_bytes_(most_bytes) {}

  /// Returns the text that changes with the run's log, end or folder; notes and locks do not count.
  static std::string last_change(const std::filesystem::path& run);

  /// Returns the picture of the run as it is now; the longest unused ones go where there is no room. From any
  /// thread.
  std::string get(const std::filesystem::path& run);
  std::size_t bytes() const;

 private:
  struct Kept {
    std::string change, picture;
    std::uint64_t used = 0;

    std::size_t bytes() const { return sizeof *this + change.size() + picture.size(); }
  };
  void make_room();

  Draw draw_;
  std::size_t most_bytes_;
  mutable std::mutex mutex_;
  std::map<std::filesystem::path, Kept> kept_;
  std::size_t bytes_ = 0;
  std::uint64_t uses_ = 0;
};

}  // namespace firn::page
