#include "files/mesh/mesh_message.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <stdexcept>

#include "files/usage_error.h"

namespace firn::mesh {
namespace {

constexpr std::size_t kMaxText = 10'000, kMaxDefects = 100, kMaxPiece = std::size_t(1) << 26;

struct Head {
  std::uint64_t problem_bytes = 0;  // above 0: the problem follows, and no mesh
  std::uint64_t vertices = 0, triangles = 0, defects = 0;
  double mm_per_unit = 1.0;
};

void put(int fd, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t n = ::write(fd, at, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw std::runtime_error("the pipe has closed");
    at += n;
    bytes -= std::size_t(n);
  }
}

void take(int fd, void* data, std::size_t bytes, const char* what) {
  char* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t n = ::read(fd, at, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw std::runtime_error(fmt::format("the message of a mesh ends within its {}", what));
    at += n;
    bytes -= std::size_t(n);
  }
}

// In pieces: memory is taken for bytes that came.
template <class T>
void take(int fd, std::vector<T>& values, std::size_t count, const char* what) {
  while (values.size() < count) {
    const std::size_t before = values.size(), more = std::min(count - before, kMaxPiece / sizeof(T));
    values.resize(before + more);
    take(fd, values.data() + before, more * sizeof(T), what);
  }
}

void put_text(int fd, const std::string& text) {
  const std::uint64_t bytes = std::min(text.size(), kMaxText);
  put(fd, &bytes, sizeof bytes);
  put(fd, text.data(), bytes);
}

std::string take_text(int fd, std::uint64_t bytes, const char* what) {
  if (bytes > kMaxText) throw std::runtime_error(fmt::format("a {} of {} bytes", what, bytes));
  std::string text(bytes, ' ');
  take(fd, text.data(), text.size(), what);
  return text;
}

}  // namespace

void send_problem(int fd, const std::string& problem) {
  Head head;
  head.problem_bytes = std::min(problem.size(), kMaxText);
  put(fd, &head, sizeof head);
  put(fd, problem.data(), head.problem_bytes);
}

void send_mesh(int fd, const MeshData& data) {
  const std::size_t defects = std::min(data.defects.size(), kMaxDefects);
  const Head head{0, data.vertices.size(), data.triangles.size(), defects, data.mm_per_unit};
  put(fd, &head, sizeof head);
  put_text(fd, data.format);
  for (std::size_t n = 0; n < defects; ++n) put_text(fd, data.defects[n]);
  put(fd, data.vertices.data(), data.vertices.size() * sizeof data.vertices[0]);
  put(fd, data.triangles.data(), data.triangles.size() * sizeof data.triangles[0]);
}

MeshData receive_mesh(int fd, std::size_t limit_bytes) {
  Head head;
  take(fd, &head, sizeof head, "head");
  if (head.problem_bytes > 0) throw UsageError(take_text(fd, head.problem_bytes, "problem"));
  MeshData data;
  constexpr std::size_t kEach = sizeof data.vertices[0];
  static_assert(kEach == sizeof data.triangles[0]);
  if (head.vertices > limit_bytes / kEach || head.triangles > limit_bytes / kEach - head.vertices ||
      head.triangles > kMaxFacets || head.defects > kMaxDefects)
    throw std::runtime_error(fmt::format("{} vertices, {} triangles and {} defects are beyond the limits",
                                         head.vertices, head.triangles, head.defects));
  if (!(std::isfinite(head.mm_per_unit) && head.mm_per_unit > 0.0))
    throw std::runtime_error("a unit that is no length");
  data.mm_per_unit = head.mm_per_unit;
  const auto text = [&](const char* what) {
    std::uint64_t bytes = 0;
    take(fd, &bytes, sizeof bytes, what);
    return take_text(fd, bytes, what);
  };
  data.format = text("format");
  for (std::uint64_t n = 0; n < head.defects; ++n) data.defects.push_back(text("defect"));
  take(fd, data.vertices, head.vertices, "vertices");
  take(fd, data.triangles, head.triangles, "triangles");
  for (const auto& t : data.triangles)
    if (std::max({t[0], t[1], t[2]}) >= data.vertices.size())
      throw std::runtime_error("a triangle without its vertices");
  return data;
}

}  // namespace firn::mesh
