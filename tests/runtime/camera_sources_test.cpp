// Folders of pictures and the bridge to the camera's protocol, through a port's wire and the camera's driver
// codec.
#include <poll.h>
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

#include "core/grid/png.h"
#include "drivers/camera/picture_line.h"
#include "runtime/camera/folder_source.h"
#include "runtime/port_wire.h"
#include "tests/support/temp_folder.h"

namespace firn::test {
namespace {

using namespace firn::camera;
using Catch::Contains;

void put_picture(const std::filesystem::path& file, int white, std::uint16_t level) {
  const std::vector<std::uint16_t> pixels(20 * 16, level);
  const std::vector<std::byte> png = write_grey_png(20, 16, white, pixels);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), std::streamsize(png.size()));
}

/// Sends a line and reads a whole reply with the driver's own framing.
class Client {
 public:
  explicit Client(const std::string& address) : wire_(parse_port_address(address)) { wire_.open(0); }
  PortWire& wire() { return wire_; }
  std::vector<std::byte> ask(const drivers::Request& request) {
    const std::string_view text = request.text();
    std::size_t sent = 0;
    REQUIRE(wire_.write(std::as_bytes(std::span(text)), sent) == PortWire::Io::kDone);
    const drivers::picture_line::PictureLineDialect dialect;
    std::vector<std::byte> got;
    for (int n = 0; n < 4000; ++n) {
      const drivers::Frame f = dialect.frame(got, &request);
      if (!got.empty() && f.kind == drivers::Frame::Kind::kReply) return got;
      pollfd p{wire_.fd(), POLLIN, 0};
      ::poll(&p, 1, 10);
      std::byte buffer[4096];
      std::size_t count = 0;
      if (wire_.read(buffer, count) == PortWire::Io::kDone) got.insert(got.end(), buffer, buffer + count);
    }
    FAIL("no whole reply");
    return {};
  }

 private:
  PortWire wire_;
};

std::string text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

TEST_CASE("a folder gives its pictures by name, and those that come later") {
  const TempFolder folder;
  put_picture(folder.path() / "b.png", 255, 2);
  put_picture(folder.path() / "a.png", 4095, 1000);
  FolderSource source(folder.path());
  const GreyShot first = source.take({});
  CHECK(first.pixels.front() == 1000);
  CHECK(first.white > 255);
  CHECK(source.take({}).pixels.front() == 2);
  put_picture(folder.path() / "c.png", 255, 3);
  CHECK(source.take({}).pixels.front() == 3);
}

TEST_CASE("a folder without a further picture says behind which one") {
  const TempFolder folder;
  put_picture(folder.path() / "only.png", 255, 2);
  FolderSource source(folder.path());
  source.take({});
  CHECK_THROWS_WITH(source.take([] { return true; }), Contains("behind only.png"));
}

TEST_CASE("a damaged file of a folder is named and passed") {
  const TempFolder folder;
  std::ofstream(folder.path() / "a.png") << "no picture";
  put_picture(folder.path() / "b.png", 255, 9);
  FolderSource source(folder.path());
  CHECK_THROWS_WITH(source.take({}), Contains("a.png"));
  CHECK(source.take({}).pixels.front() == 9);
}

TEST_CASE("a folder is a camera's port: its pictures come through the camera's own codec") {
  namespace line = drivers::picture_line;
  const TempFolder folder;
  put_picture(folder.path() / "a.png", 65535, 40'000);
  Client client("folder:" + folder.path().string());
  REQUIRE(client.wire().state() == PortWire::State::kOpen);
  CHECK_THAT(text_of(client.ask(line::identify())), Contains("OK ID folder"));
  CHECK(text_of(client.ask(line::set(100.0, 0.0, 60.0))) == "OK SET\n");
  const auto picture = line::parse_picture(client.ask(line::snap(1, 1'000'000)));
  REQUIRE(picture);
  CHECK(picture->width == 20);
  CHECK(picture->pixels.back() == 40'000);
  CHECK_THAT(text_of(client.ask(line::snap(2, 1'000'000))),
             Contains("NO SNAP there is no picture behind a.png"));
}

TEST_CASE("a folder and a V4L2 device that are not there say so by their address") {
  Client folder("folder:/nonexistent/pictures"), device("v4l2:/nonexistent/video0");
  CHECK(folder.wire().trouble() == "folder:/nonexistent/pictures: is no folder");
  CHECK(device.wire().trouble() == "v4l2:/nonexistent/video0: No such file or directory");
}

TEST_CASE("a file that is no V4L2 device is refused by name") {
  Client device("v4l2:/dev/null");
  CHECK_THAT(device.wire().trouble(), Contains("v4l2:/dev/null: is no V4L2 device"));
}

TEST_CASE("addresses of cameras come back from their texts") {
  for (const std::string text : {"v4l2:/dev/video0", "v4l2:/dev/video2?size=1280x960&format=Y12&delay_us=60",
                                 "folder:/data/strobe pictures"})
    CHECK(to_text(parse_port_address(text)) == text);
}

TEST_CASE("an address of a camera that is none names the piece") {
  CHECK_THROWS_WITH(parse_port_address("v4l2:"), Contains("names no device file"));
  CHECK_THROWS_WITH(parse_port_address("v4l2:/dev/video0?size=12"),
                    Contains("size '12' must be as 1280x960"));
  CHECK_THROWS_WITH(parse_port_address("v4l2:/dev/video0?format=RGB"), Contains("option 'format=RGB'"));
  CHECK_THROWS_WITH(parse_port_address("folder:"), Contains("names no folder"));
}

}  // namespace firn::test
