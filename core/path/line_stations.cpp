#include "core/path/line_stations.h"

#include <algorithm>
#include <cmath>

#include "core/path/bytes.h"
#include "core/path/polyline.h"

namespace firn {
namespace {

constexpr double kSame_mm = 1e-6;
constexpr std::uint32_t kJobMark = 0x4a4c5246;  // "FRLJ"
constexpr std::size_t kMostSegments = 100'000;

Point2 along(const PrintSegment& s, double mm) {
  const double share = mm / distance(s.from, s.to);
  return {s.from.x_mm + share * (s.to.x_mm - s.from.x_mm), s.from.y_mm + share * (s.to.y_mm - s.from.y_mm)};
}

Point2 direction_of(const PrintSegment& s) {
  const double l = distance(s.from, s.to);
  return {(s.to.x_mm - s.from.x_mm) / l, (s.to.y_mm - s.from.y_mm) / l};
}

bool joined(const PrintSegment& a, const PrintSegment& b) { return distance(a.to, b.from) <= kSame_mm; }

// One straight line goes on: the neighbour is no other line.
bool goes_on(const PrintSegment& a, const PrintSegment& b) {
  const Point2 u = direction_of(a), v = direction_of(b);
  return joined(a, b) && u.x_mm * v.x_mm + u.y_mm * v.y_mm > 1.0 - 1e-9;
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
  for (std::size_t i = 0; i < count; ++i) {
    const PrintSegment& s = job.segments[i];
    const double length = distance(s.from, s.to);
    const int parts = std::max(1, int(std::ceil(length / spacing_mm - 1e-9)));
    for (int k = 0; k < parts; ++k) {
      LineStation at;
      at.segment = std::int32_t(i);
      at.from_mm = length * k / parts;
      at.to_mm = length * (k + 1) / parts;
      at.at = along(s, 0.5 * (at.from_mm + at.to_mm));
      at.direction = direction_of(s);
      for (std::size_t j = 0; j < count; ++j) {
        if (j == i || (j + 1 == i && goes_on(job.segments[j], s)) ||
            (j == i + 1 && goes_on(s, job.segments[j])))
          continue;
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

std::vector<std::byte> encode_job(const PrintJob& job) {
  ByteWriter out;
  out.put(kJobMark);
  out.put(std::uint32_t(job.segments.size()));
  const auto put = [&](const Point2& p) {
    out.put(p.x_mm);
    out.put(p.y_mm);
  };
  put(job.start);
  put(job.end);
  for (const PrintSegment& s : job.segments) {
    put(s.from);
    put(s.to);
    out.put(s.speed_mm_s);
  }
  return out.take();
}

PrintJob decode_job(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  if (in.get<std::uint32_t>("the mark") != kJobMark) in.fail("is no print job");
  const std::size_t count = in.get_count("segments", kMostSegments);
  if (count == 0) in.fail("the print job has no segments");
  const auto point = [&](const char* what) {
    Point2 p;
    p.x_mm = in.get_number(what, -1e5, 1e5);
    p.y_mm = in.get_number(what, -1e5, 1e5);
    return p;
  };
  PrintJob job;
  job.start = point("start");
  job.end = point("end");
  for (std::size_t n = 0; n < count; ++n) {
    PrintSegment s;
    s.from = point("from");
    s.to = point("to");
    s.speed_mm_s = in.get_number("speed", 0.0, 1e6);
    if (!(distance(s.from, s.to) > kSame_mm)) in.fail("segment " + std::to_string(n) + " has no length");
    job.segments.push_back(s);
  }
  in.end();
  return job;
}

}  // namespace firn
