#include "core/path/line_stations.h"

#include <algorithm>
#include <cmath>

#include "core/path/polyline.h"

namespace firn {
namespace {

constexpr double kSame_mm = 1e-6;

Point2 along(const PrintSegment& s, double mm) {
  const double share = mm / distance(s.from, s.to);
  return {s.from.x_mm + share * (s.to.x_mm - s.from.x_mm), s.from.y_mm + share * (s.to.y_mm - s.from.y_mm)};
}

Point2 direction_of(const PrintSegment& s) {
  const double l = distance(s.from, s.to);
  return {(s.to.x_mm - s.from.x_mm) / l, (s.to.y_mm - s.from.y_mm) / l};
}

bool joined(const PrintSegment& a, const PrintSegment& b) { return distance(a.to, b.from) <= kSame_mm; }

constexpr double kGentle = 0.866;  // cosine of 30 degrees: a smaller turn is a curve, a larger one a corner
constexpr double kAstray = 0.5;    // cosine of 60 degrees: a curve that has turned by more is another line

bool turns_less(const PrintSegment& a, const PrintSegment& b, double cosine) {
  const Point2 u = direction_of(a), v = direction_of(b);
  return u.x_mm * v.x_mm + u.y_mm * v.y_mm > cosine;
}

// Segments of one stroke that go on as a curve: by segment, the next one along it; count: none.
std::vector<std::size_t> next_along(const PrintJob& job) {
  const std::size_t count = job.segments.size();
  std::vector<std::size_t> next(count, count);
  std::size_t first = 0;  // of the stroke
  for (std::size_t i = 0; i < count; ++i) {
    const bool ends = i + 1 == count || !joined(job.segments[i], job.segments[i + 1]);
    const std::size_t j = ends ? first : i + 1;  // a closed stroke goes on at its beginning
    if (j != i && joined(job.segments[i], job.segments[j]) &&
        turns_less(job.segments[i], job.segments[j], kGentle))
      next[i] = j;
    if (ends) first = i + 1;
  }
  return next;
}

// Marks the segments that are the same line as segment i where it is measured.
void mark_line(const PrintJob& job, const std::vector<std::size_t>& along, std::size_t i,
               std::vector<char>& same) {
  const std::size_t count = along.size();
  for (std::size_t j = along[i];
       j < count && !same[j] && turns_less(job.segments[i], job.segments[j], kAstray); j = along[j])
    same[j] = 1;
}

}  // namespace

double distance_to(const Point2& p, const PrintSegment& s) {
  const double share = nearest_share(p, s.from, s.to);
  return distance(
      p, {s.from.x_mm + share * (s.to.x_mm - s.from.x_mm), s.from.y_mm + share * (s.to.y_mm - s.from.y_mm)});
}

std::vector<LineStation> line_stations(const PrintJob& job, double spacing_mm) {
  std::vector<LineStation> stations;
  const std::size_t count = job.segments.size();
  const std::vector<std::size_t> next = next_along(job);
  std::vector<std::size_t> before(count, count);
  for (std::size_t i = 0; i < count; ++i)
    if (next[i] < count) before[next[i]] = i;
  std::int32_t line = -1;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<char> same(count, 0);
    same[i] = 1;
    mark_line(job, next, i, same);
    mark_line(job, before, i, same);
    if (i == 0 || next[i - 1] != i) ++line;
    const PrintSegment& s = job.segments[i];
    const double length = distance(s.from, s.to);
    const int parts = std::max(1, int(std::ceil(length / spacing_mm - 1e-9)));
    for (int k = 0; k < parts; ++k) {
      LineStation at;
      at.segment = std::int32_t(i);
      at.line = line;
      at.from_mm = length * k / parts;
      at.to_mm = length * (k + 1) / parts;
      at.at = along(s, 0.5 * (at.from_mm + at.to_mm));
      at.direction = direction_of(s);
      for (std::size_t j = 0; j < count; ++j) {
        if (same[j]) continue;
        for (const double mm : {at.from_mm, 0.5 * (at.from_mm + at.to_mm), at.to_mm})
          at.room_mm = std::min(at.room_mm, distance_to(along(s, mm), job.segments[j]));
      }
      stations.push_back(at);
    }
  }
  return stations;
}

std::vector<LineEnd> line_ends(const PrintJob& job, double clearance_mm) {
  std::vector<LineEnd> ends;
  const std::size_t count = job.segments.size();
  for (std::size_t i = 0; i < count; ++i) {
    const PrintSegment& s = job.segments[i];
    for (const bool start : {true, false}) {
      if (start ? i > 0 && joined(job.segments[i - 1], s) : i + 1 < count && joined(s, job.segments[i + 1]))
        continue;
      LineEnd end;
      end.segment = std::int32_t(i);
      end.start = start;
      end.at = start ? s.from : s.to;
      end.direction = direction_of(s);
      end.length_mm = distance(s.from, s.to);
      for (std::size_t j = 0; j < count; ++j)
        end.free = end.free && (j == i || distance_to(end.at, job.segments[j]) > clearance_mm);
      ends.push_back(end);
    }
  }
  return ends;
}

}  // namespace firn
