// lcm-spy with Firn's types and views watches a live print; its display is read back from its picture.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

namespace {

struct Said {
  int status = -1;
  std::string out;
};

Said run_firn(const std::string& arguments) {
  FILE* pipe = ::popen(("env -u DISPLAY '" FIRN_BINARY_DIR "/bin/firn' " + arguments + " 2>&1").c_str(), "r");
  REQUIRE(pipe);
  Said said;
  for (char b[256]; std::fgets(b, sizeof b, pipe);) said.out += b;
  const int ended = ::pclose(pipe);
  said.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
  return said;
}

/// Different colours in a part of the picture, given in fractions of its width and height.
std::size_t colours(const cv::Mat& picture, double x0, double y0, double x1, double y1) {
  std::set<int> seen;
  for (int y = int(y0 * picture.rows); y < int(y1 * picture.rows); ++y)
    for (int x = int(x0 * picture.cols); x < int(x1 * picture.cols); ++x) {
      const cv::Vec3b& c = picture.at<cv::Vec3b>(y, x);
      seen.insert(c[0] << 16 | c[1] << 8 | c[2]);
    }
  return seen.size();
}

bool has_colour(const cv::Mat& picture, cv::Vec3b bgr) {
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      if (picture.at<cv::Vec3b>(y, x) == bgr) return true;
  return false;
}

}  // namespace

TEST_CASE("lcm-spy shows the height map and the layer error of a live print, on a virtual screen") {
  if (skipped()) return;
  Experiment e = tiny_part(4);
  e.part.shape.height_mm = 2.0;  // a minute and more: Java may take its time to start
  e.process.nozzle_gap_mm = 3.0;
  LiveRun run(e);
  run.start(false);
  INFO(run.path());
  REQUIRE(run.wait_started());
  const std::string png = (run.path() / "spy.png").string();
  const Said spy = run_firn("spy '" + run.path().string() + "' --layers 3 --screenshot '" + png + "'");
  INFO(spy.out);
  CHECK(spy.status == 0);
  CHECK_THAT(spy.out, Catch::Contains("Found 2 plugins"));
  CHECK_THAT(spy.out, Catch::Contains("spy.png: the screen after 3 layers"));
  const cv::Mat picture = cv::imread(png);
  REQUIRE(picture.cols == 1600);
  REQUIRE(picture.rows == 1000);
  CHECK(colours(picture, 0.6, 0.05, 0.94, 0.6) >= 20);  // the heat map: 81 cells of different height
  CHECK(has_colour(picture(cv::Rect(0, 600, 880, 380)), {40, 39, 214}));  // the curve of the RMS, 0xd62728
  CHECK(has_colour(picture(cv::Rect(0, 600, 880, 380)), {44, 160, 44}));  // the curve of the unevenness
  run.interrupt();
  CHECK(run.wait() == 130);

  const Said late = run_firn("spy '" + run.path().string() + "' --screenshot '" + png + "'");
  CHECK(late.status == 2);
  CHECK_THAT(late.out, Catch::Contains("does not print now"));
}

TEST_CASE("A picture of more layers than the print has left ends with the print") {
  if (skipped()) return;
  LiveRun run(tiny_part(4));
  run.start(false);
  INFO(run.path());
  REQUIRE(run.wait_started());
  const std::string png = (run.path() / "spy.png").string();
  const Said spy = run_firn("spy '" + run.path().string() + "' --layers 100000 --screenshot '" + png + "'");
  INFO(spy.out);
  if (spy.status == 0) CHECK_THAT(spy.out, !Catch::Contains("after 100000 layers"));
  CHECK(run.wait_finished() == 0);
}

TEST_CASE("firn spy says what is wrong: no display, no such run, a bus in one process") {
  const Said blind = run_firn("spy --bus 'udpm://239.255.76.67:21000?ttl=0'");
  CHECK(blind.status == 2);
  CHECK_THAT(blind.out, Catch::Contains("no display"));
  const Said nowhere = run_firn("spy /nonexistent/run");
  CHECK(nowhere.status == 2);
  CHECK_THAT(nowhere.out, Catch::Contains("/nonexistent/run"));
  const Said inside = run_firn("spy --bus in-process");
  CHECK(inside.status == 2);
}
