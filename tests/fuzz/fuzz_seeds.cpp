// fuzz_seeds DIR: writes DIR/<target>/ with small valid inputs for each fuzz target.
#include <cstdio>
#include <cstring>

#include "config/experiment.h"
#include "core/grid/npy.h"
#include "core/slice/paths/print_paths.h"
#include "drivers/heater/thermostat.h"
#include "drivers/robot/fvp.h"
#include "drivers/valve/fvb.h"
#include "files/path/layer_file.h"
#include "files/path/trajectory_file.h"
#include "files/record/event_log.h"
#include "files/record/packed.h"
#include "files/record/record_file.h"
#include "files/record/squeeze.h"
#include "files/text_file.h"
#include "lcmtypes/schema.h"
#include "tests/files/record/event_samples.h"
#include "tests/fuzz/known_log.h"
#include "tests/fuzz/run_seeds.h"
#include "tests/lcmtypes/samples.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/valve_firmware.h"

using namespace firn;
using namespace firn::test;

namespace {

std::filesystem::path folder;

void seed(const char* target, const std::string& name, std::span<const std::byte> bytes) {
  std::filesystem::create_directories(folder / target);
  write_file(folder / target / name, bytes);
}

void seed_message(const std::string& name, const std::vector<std::byte>& message) {
  const auto& types = Schema::builtin().types();
  std::uint8_t number = 0;
  while (&types[number] != Schema::builtin().type_of(message)) ++number;
  std::vector<std::byte> input{std::byte(number)};
  input.insert(input.end(), message.begin() + 8, message.end());
  seed("fuzz_messages", name, input);
}

// Each type once, empty: a fuzzer that starts from them reaches every decoder in its first second.
template <class... M>
void seed_each_type(TypeList<M...>) {
  (seed_message(M::getTypeName(), encode(M{})), ...);
}

void seed_logs(std::size_t events, std::size_t longest) {
  const Scratch scratch("fuzz-seeds");
  write_events(scratch / "a.lcm", some_events(events, longest, events));
  const Bytes log = read_bytes(scratch / "a.lcm"), index = read_bytes(scratch / "a.lcm.idx");
  Bytes input(4);
  const auto split = std::uint32_t(log.size());
  std::memcpy(input.data(), &split, 4);
  input.insert(input.end(), log.begin(), log.end());
  input.insert(input.end(), index.begin(), index.end());
  const std::string name = std::to_string(events) + "-events";
  seed("fuzz_event_log", name, input);
  seed("fuzz_record_file", name, index);
}

std::vector<std::byte> behind(std::uint8_t choice, std::span<const std::byte> bytes) {
  std::vector<std::byte> input{std::byte(choice)};
  input.insert(input.end(), bytes.begin(), bytes.end());
  return input;
}

void seed_packed() {
  const Scratch scratch("fuzz-seeds");
  write_events(scratch / "a.lcm", some_events(3, 40, 3));
  const Bytes records = read_bytes(scratch / "a.lcm.idx");
  const auto log = as_span(fuzz::kKnownLog);
  seed("fuzz_packed", "alone", behind(0, record::pack(records, {}, "")));
  seed("fuzz_packed", "known", behind(0, record::pack(records, log, "log.lcm")));
  const auto size = std::uint16_t(records.size());
  Bytes squeezed{std::byte(size & 255), std::byte(size >> 8)};
  const Bytes items = record::squeeze_records(records);
  squeezed.insert(squeezed.end(), items.begin(), items.end());
  seed("fuzz_packed", "squeezed", behind(1, squeezed));
  seed("fuzz_packed", "plain", behind(2, records));
}

void seed_plans() {
  seed("fuzz_machine", "stage",
       as_span("[machine]\nkind = \"stage\"\n[axis_1]\nlow_mm = -10\nhigh_mm = 20\n[valve]\ntable_hz = [100, "
               "200]\ntable_mm3_s = [20, 50]\n"));
  seed("fuzz_machine", "scara",
       as_span("[total]\njerk_mm_s3 = 4000.0\n[joint_1]\nlow_deg = -105.0\nrate_deg_s = 33.0\n"));
  seed("fuzz_paths", "csv", behind(0, as_span("x_mm,y_mm,speed_mm_s\n0,0,\n1.5,-2e1,50\n\n3,4,10\n")));
  seed("fuzz_paths", "csv-columns", behind(0, as_span("yaw_rad;z_mm;x_in;y_um\n0.1;3;1;2000\n0.2;3;2;1\n")));
  seed("fuzz_paths", "gcode",
       behind(2, as_span("%\nG21 G90 G17 F600\nG0 X1 Y2\nG1 X3.5\nG2 X5 Y4 I0 J2\nG3 X1 Y1 R9\n"
                         "G5 X9 Y9 I1 J0 P0 Q-1\nG91 G20 G1 X1 (a)\nM2\n")));
  seed("fuzz_paths", "gcode-slicer",
       behind(2, as_span("M83\nG28 X Y\nG92 E0\nSTART_PRINT T=60\nG1 X10 F600\nG1 X30 E1\nG10\nG1 "
                         "X5\nG11\nG53 G0 Z0\n")));
  seed("fuzz_paths", "gcode-laser",
       behind(2, as_span("M4 S0\nG0 X1e-05 Y1\nG1 X3 S80\nG1 X4 S0\nG2 X4 Y1 I5\nM5 I\n")));
  seed("fuzz_paths", "csv-quoted", behind(0, as_span("sep=;\n# made\n\"x\";\"y [mm]\"\n\"0,5\";1\r2;3\n")));
  seed("fuzz_paths", "svg",
       behind(
           3,
           as_span("<svg width=\"20mm\" viewBox=\"0 0 40 20\"><g transform=\"translate(1 2) rotate(30)\">"
                   "<path d=\"M1,1 l2-1.5.5 1 H9 v-2 C1 2 3 4 5 6 s1 2 3 4 q1 1 2 0 t2 2 a3 2 30 0150 5z\"/>"
                   "<circle r=\"3\" cx=\"2\"/><rect width=\"4\" height=\"1in\"/>"
                   "<polygon points=\"0,0 1 1,2 0\"/><line x2=\"5\"/></g></svg>")));
  seed(
      "fuzz_paths", "dxf",
      behind(4,
             as_span(
                 "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n1\n0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\n"
                 "LAYER\n0\nLAYER\n2\nA\n70\n1\n62\n-7\n0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
                 "0\nLINE\n8\n0\n10\n1\n20\n2\n11\n3\n21\n2\n0\nARC\n10\n3\n20\n3\n40\n1\n50\n-90\n51\n90\n"
                 "0\nTEXT\n8\nA\n0\nCIRCLE\n10\n5\n20\n5\n40\n2.5\n230\n-1\n"
                 "0\nLWPOLYLINE\n90\n2\n70\n1\n10\n0\n20\n0\n42\n1\n10\n4\n20\n0\n42\n-0.5\n"
                 "0\nPOLYLINE\n70\n8\n0\nVERTEX\n10\n1\n30\n2\n0\nVERTEX\n10\n3\n30\n2\n0\nSEQEND\n"
                 "0\nELLIPSE\n10\n1\n20\n1\n11\n4\n21\n1\n40\n.5\n41\n0\n42\n2\n"
                 "0\nSPLINE\n71\n2\n40\n0\n40\n0\n40\n0\n40\n1\n40\n1\n40\n1\n41\n1\n41\n2\n41\n1\n"
                 "10\n0\n20\n0\n10\n1\n20\n3\n10\n4\n20\n0\n0\nENDSEC\n0\nEOF\n")));
  seed(
      "fuzz_paths", "svg-styles",
      behind(
          3,
          as_span(
              "<svg viewBox='0 0 9 9' style='width:9mm;height:50%'><style>/*a*/ .a,g > "
              "path#i:hover{fill:none!"
              "important} @media all{*{stroke:rgba(1,2,3,.5)}}</style><defs><symbol id='s' viewBox='0 0 1 1' "
              "overflow='visible'><path class='a b' d='M0 0H9'/></symbol><clipPath id='c'><rect width='9' "
              "height='9'/></clipPath></defs><use href='#s' x='10%' width='3' height='2'/><switch>"
              "<image requiredExtensions='x'/><g style='transform:rotate(.1turn) translateX(2px);"
              "transform-origin:left 1px;clip-path:url(#c)'><path d='M1 1h1'/><text opacity='0'>t</text></g>"
              "</switch><svg x='1' width='5' height='5' preserveAspectRatio='xMinYMax slice' "
              "viewBox='0 0 2 1'><circle r='5%'/></svg></svg>")));
  seed(
      "fuzz_paths", "dxf-blocks",
      behind(4, as_span("0\nSECTION\n2\nHEADER\n9\n$MEASUREMENT\n70\n0\n0\nENDSEC\n0\nSECTION\n2\nBLOCKS\n0\n"
                        "BLOCK\n2\nB\n10\n1\n20\n2\n0\nCIRCLE\n40\n1\n0\nINSERT\n2\nc\n50\n30\n0\nENDBLK\n0\n"
                        "BLOCK\n2\nC\n"
                        "0\nLWPOLYLINE\n10\n0\n20\n0\n42\n."
                        "5\n10\n3\n20\n1\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
                        "0\nINSERT\n2\nb\n41\n2\n42\n-1\n50\n45\n70\n2\n44\n9\n230\n-"
                        "1\n0\nHATCH\n0\nSPLINE\n70\n1\n71\n3\n"
                        "11\n0\n21\n0\n11\n3\n21\n0\n11\n3\n21\n3\n0\nSPLINE\n11\n0\n21\n0\n11\n5\n21\n1\n12"
                        "\n0\n22\n1\n0\nENDSEC\n"
                        "0\nEOF\n")));
  seed(
      "fuzz_paths", "json-shapes",
      behind(1, as_span("{\"paths\":[{\"points\":[[0,0],{\"to\":[4,0,9],\"centre\":[2,0],\"clockwise\":true},"
                        "{\"to\":[9,1],\"control\":[5,1,6,-2]}]}]}")));
  seed("fuzz_paths", "csv-yaw",
       behind(0, as_span("x_mm,y_mm,speed_mm_s,yaw_deg\n0,0,,90\n1.5,-2e1,50,-45\n")));
  seed("fuzz_paths", "json-yaw",
       behind(1, as_span("{\"paths\":[{\"yaw_deg\":[1,2],\"points\":[[0,0],[1,2]]}]}")));
  seed("fuzz_paths", "json",
       behind(1, as_span("{\"version\":1,\"paths\":[{\"kind\":\"fill\",\"closed\":true,\"points\":[[0,0],[1,"
                         "2,50],[3,4,null]]}]}")));
  PlannedPath path{1, 0, PathKind::kFill, 10.0, {}};
  path.trajectory = {1,
                     0.016,
                     2,
                     {"rad", "rad"},
                     {0.1, 0.2, 0.1, 0.3, 0.1, 0.4},
                     {{{"total speed", 0.9, 0.1}}, 0.032, 0.0, 0.4}};
  seed("fuzz_trajectory", "path", behind(1, firn::encode(path)));
  const std::filesystem::path file = folder / "fuzz_trajectory" / "file.traj";
  TrajectoryWriter out(file, {"m", "certified", "fuzz", 0.016, {}, {"J1", "J2"}, {"rad", "rad"}});
  out.add(path);
  out.finish();
  const record::MappedFile whole(file);
  seed("fuzz_trajectory", "file", behind(0, whole.bytes()));
}

void seed_slices() {
  namespace mb = mesh_bytes;
  const SampleMesh m = gear(2);
  seed("fuzz_mesh", "binary-stl", behind(0, mb::binary_stl(m)));
  seed("fuzz_mesh", "ascii-stl",
       behind(0, mb::ascii_stl(prism(3, 1.0f, 0.0f, 0.0f, [](std::uint32_t) { return 1.0; }))));
  seed("fuzz_mesh", "ply", behind(1, mb::binary_ply(m, false, true)));
  seed("fuzz_mesh", "big-endian-ply", behind(1, mb::binary_ply(m, true)));
  seed("fuzz_mesh", "ascii-ply", behind(1, mb::ascii_ply(m)));
  seed("fuzz_mesh", "obj", behind(2, mb::obj(m)));
  slice::LayerPaths layer{1, 2500, 2500, {}, {}, 0};
  layer.lines.add(std::vector<geometry::Point>{{0, 0}, {30000, 0}, {30000, 30000}});
  layer.info.push_back({PathKind::kBoundary, 1, true, 15000});
  seed("fuzz_path_file", "layer", behind(1, slice::encode(layer)));
  const std::filesystem::path file = folder / "fuzz_path_file" / "file.paths";
  LayerWriter out(file, {"fuzz", 1, {{"part", "water"}, {"scaffold", "scaffold"}}, "laser", "[layer]\n"});
  out.add(slice::encode(layer), layer, {});
  out.finish();
  const record::MappedFile whole(file);
  seed("fuzz_path_file", "file", behind(0, whole.bytes()));
  seed("fuzz_path_file", "print",
       behind(2, slice::encode(slice::PrintPaths{{"fuzz", 1, {{"part", "water"}}, "laser", ""}, {layer}})));
  seed("fuzz_slice", "stl", mb::binary_stl(m));
  std::vector<std::uint8_t> lattice;
  for (std::uint32_t n = 0; n < 20 * 9; ++n) lattice.push_back(std::uint8_t(n * n / 7));
  seed("fuzz_slice", "lattice", std::as_bytes(std::span(lattice)));
}

// Requests of a host to the boxes' firmware: a list that fires, set points and readings.
void seed_firmware() {
  using namespace drivers;
  const std::vector<std::uint16_t> ticks{0, 1, 2, 5, 9};
  const std::uint16_t crc = fvb::list_crc(ticks);
  const std::byte sum[] = {std::byte(crc & 255), std::byte(crc >> 8)}, for_ever[4] = {};
  std::vector<std::byte> valve;
  fvb::encode(fvb::Type::kHello, 60, {}, valve);
  fvb::encode(62, fvb::Begin{7, 1, std::uint16_t(ticks.size()), 2000, 1250}, valve);
  fvb::encode_data(63, 0, ticks, valve);
  fvb::encode(fvb::Type::kEnd, 64, sum, valve);
  fvb::encode(fvb::Type::kArm, 65, for_ever, valve);
  fvb::encode(fvb::Type::kStatus, 66, {}, valve);
  fvb::encode(fvb::Type::kDisarm, 68, {}, valve);
  fvb::encode(fvb::Type::kAbort, 70, {}, valve);
  seed("fuzz_valve_firmware", "list", valve);
  std::string heater;
  for (const char* text : {"T?", "S,1,2000", "S,2,-5000", "S,4,1", "T??"}) {
    LineWriter line;
    heater += line.text(text).finish(0);
  }
  seed("fuzz_heater_firmware", "lines", as_span(heater));
}

// Codecs of the path printer: {codec, step, bytes…}; and its drivers, spoken to as in their transcripts.
void seed_ice() {
  using namespace drivers;
  const auto text = [](std::uint8_t codec, const std::string& name, std::string_view bytes) {
    std::vector<std::byte> input{std::byte(codec), std::byte(6)};
    for (const char c : bytes) input.push_back(std::byte(c));
    seed("fuzz_ice_codecs", name, input);
  };
  LineWriter status = fvp::request(7, "ACK");
  fvp::put(status, fvp::Status{});
  text(0, "status", status.finish(1));
  LineWriter done = fvp::event(3, "PATH_DONE");
  text(0, "event", done.word(1).word(48).finish(1));
  std::vector<std::byte> valve;
  fvb::encode(1, fvb::Status{}, valve);
  fvb::encode_data(2, 0, std::vector<std::uint16_t>{1, 2, 3}, valve);
  text(1, "valve", {reinterpret_cast<const char*>(valve.data()), valve.size()});
  text(2, "value", "+01.2345");
  text(2, "dump", "1,+01.2345,XXXXXXXX,-FFFFFFF");
  text(2, "lines", "TG,1,+01.2345\rPR,0\r");
  text(3, "reading", "T,2137,OPEN,-1950,5");
  LineWriter line;
  text(3, "line", line.text("T,1,2,3,0").finish(0));
  seed_firmware();
}

void seed_vplus() {
  for (const char* file : {"firn.v2", "lines.v2", "motion.v2", "paths.v2"}) {
    const std::string text = read_file(std::string(FIRN_SOURCE_DIR) + "/drivers/robot/vplus/" + file);
    // Each of its programs alone: one that calls another is refused there, and the lines before it are read.
    for (std::size_t at = 0, end; (end = text.find(".END", at)) != std::string::npos; at = end + 4)
      seed("fuzz_vplus", file + std::to_string(at), as_span(text.substr(at, end + 5 - at)));
  }
  constexpr std::string_view kStatements = R"(.PROGRAM a()
	AUTO n, $s, q[4]
	FOR n = 1 TO 3 STEP 2
		CASE n OF
		  VALUE 1:
			q[n] = VAL($MID("12",n,1)) BAND ^HF
		  ANY
			CALL b(q[1], $s)
		END
	END
	ATTACH (5, 4) "TCP"
	FOPEN (5, 16) "/LOCAL_PORT 4096"
	WHILE TRUE DO
		READ (5, h, 1) $s
		IF IOSTAT(5) > 0 THEN
			WRITE (5, h) $s, /S
		ELSE
			WAIT
		END
	END
.END
.PROGRAM b(x, $t)
	x = -x*2
	$t = $ENCODE(/I0,x,"y")+$DECODE($t,"y",0)
.END
)";
  seed("fuzz_vplus", "statements", as_span(kStatements));
}

// The first byte chooses the channel; a message or its JSON follows.
void seed_own_programs() {
  own_values_t values{};
  values.header.seq = 1;
  values.values = {1.0, 2.0};
  values.n = 2;
  const std::vector<std::byte> message = encode(values);
  std::vector<std::byte> input{std::byte{0}};
  input.insert(input.end(), message.begin(), message.end());
  seed("fuzz_own_message", "values", input);
  seed("fuzz_own_message", "json",
       as_span(
           "\x03{\"name\": \"room\", \"unit\": \"degC\", \"sample_utime_us\": 0, \"values\": [21.5, null]}"));
  seed("fuzz_own_message", "flow", as_span("\x02{\"layer\": 3, \"factor\": [1.1, 0.9]}"));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds DIR\n");
    return 2;
  }
  folder = argv[1];
  for (const std::size_t n : {1u, 3u, 12u}) seed_logs(n, 40);
  seed_packed();
  const std::string experiment = dump(Experiment{});
  seed("fuzz_experiment", "default", std::as_bytes(std::span(experiment)));
  const std::string study =
      "seeds = 3\n[[scheme]]\nname = \"a\"\nset = [\"control.scheme=smf\"]\n[vary]\n\"control.mpc.horizon\" "
      "= [1, 2]\n";
  seed("fuzz_study", "small", std::as_bytes(std::span(study)));
  const std::string recorded =
      "[[scheme]]\nname = \"a\"\nruns = [\"r/1\", \"r/2\"]\n[[scheme]]\nname = \"b\"\nruns = [\"r/3\", "
      "\"r/4\"]\n";
  seed("fuzz_study", "recorded", std::as_bytes(std::span(recorded)));
  const std::string designed =
      "seeds = 2\n[[scheme]]\nname = \"a\"\n[zip]\n\"control.smf.kp\" = [1, 2]\n[sample]\ndesign = "
      "\"sobol\"\npoints = 2\nplant.drift = [0.0, 0.1]\n[prior]\n\"plant.sensor_noise_mm\" = {mean = 0.002, "
      "std = 0.001}\n\"plant.size_std\" = {from = 0.01, to = 0.1, scale = \"log\"}\n";
  seed("fuzz_study", "designed", std::as_bytes(std::span(designed)));
  const Bytes map = encode(some_height_map(3, 2));
  Bytes datagram{std::byte(0), std::byte(std::min<std::size_t>(map.size(), 255))};
  datagram.insert(datagram.end(), map.begin(), map.end());
  seed("fuzz_transport", "map", datagram);
  // {driver, bytes at once, pause, bytes…}: stage, jet, profiler, lamp, robot, valve, point laser, heater,
  // gas, Microdrop
  using namespace std::string_view_literals;
  static constexpr std::string_view kTalk[] = {"\x00\x02\x01%\n\x03\x01%0\n"sv,
                                               "\x01\x01\x01>\x04\x01\x06\x01\x00\x01"sv,
                                               "\x02\x04\x01\x0c\x00\x00\x00"sv,
                                               "\x03\x09\x01READY0A\r\x0c\x01Received42\r"sv,
                                               "\x06\x03\x01R0\r\x05\x01PR,0\r\x00\xfa"sv,
                                               "\x08\x0b\x01"
                                               "A   GP07R1\r"
                                               "\x0b\x01"
                                               "B   10v20\r "
                                               "\x2d\x01"
                                               "A +014.6 +021.8 +000.0 +000.0 +000.0     N2\r"sv,
                                               "\x09\x03\x01OK\r\x03\x01OK\r\x04\x01 72\r"sv};
  for (std::size_t n = 0; n < std::size(kTalk); ++n)
    seed("fuzz_instruments", std::to_string(n), std::as_bytes(std::span(kTalk[n])));
  seed_ice();
  seed_vplus();
  seed_own_programs();
  seed_each_type(AllTypes{});
  seed_message("header", encode(some_header()));
  seed_message("grid", encode(some_grid(3, 2)));
  seed_message("map", encode(some_height_map(3, 2)));
  seed_message("plan", encode(some_layer_plan(3, 2)));
  seed_message("pass", encode(some_pass(3, 2)));
  seed_message("heartbeat", encode(some_heartbeat()));
  const std::string_view texts = lcm_type_texts();
  seed("fuzz_type_texts", "header", as_span(texts.substr(0, texts.find("package", 10))));
  seed("fuzz_type_texts", "nested",
       as_span(
           "package a; struct b_t { int8_t n; } struct c_t { int16_t m; b_t b; b_t c[m][2]; string s[m]; }"));
  seed("fuzz_type_texts", "constants",
       as_span("package a; enum m_t { kA, kB = 0x10 } struct d_t { const int8_t N = 3, W = 0x2; int8_t n; "
               "m_t m[N]; double v[W][n]; }"));
  GridSpec grid;
  grid.nx = 3;
  grid.ny = 2;
  grid.pitch_x_mm = grid.pitch_y_mm = 1;
  seed("fuzz_npy", "heights", to_npy(HeightMap(grid)));
  seed("fuzz_npy", "mask", to_npy(Mask(grid)));
  seed_plans();
  seed_slices();
  fuzz::seed_runs(seed);
  return 0;
}
