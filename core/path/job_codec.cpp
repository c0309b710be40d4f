#include "core/path/job_codec.h"

#include <cstdint>
#include <string>

#include "core/path/bytes.h"
#include "core/path/polyline.h"

namespace firn {
namespace {

constexpr double kShortest_mm = 1e-6;           // of a segment
constexpr std::uint32_t kJobMark = 0x4a4c5246;  // "FRLJ"
constexpr std::size_t kMaxSegments = 100'000;

}  // namespace

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
  const std::size_t count = in.get_count("segments", kMaxSegments);
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
    if (!(distance(s.from, s.to) > kShortest_mm)) in.fail("segment " + std::to_string(n) + " has no length");
    job.segments.push_back(s);
  }
  in.end();
  return job;
}

}  // namespace firn
