#include "tests/fuzz/run_seeds.h"

#include <array>
#include <cstring>

#include "core/grid/npy.h"
#include "core/grid/png.h"
#include "files/record/event_format.h"
#include "files/record/record_file.h"
#include "plant/world/world.h"
#include "print/operator/print_queue.h"
#include "procs/bus/lcm_packet.h"
#include "procs/relay/hello.h"
#include "runtime/relay/frame.h"
#include "tests/files/record/scratch.h"
#include "tests/fuzz/node_setups.h"
#include "tests/fuzz/small_worlds.h"
#include "tests/support/mesh_samples.h"

namespace firn::fuzz {
namespace {

using test::as_span;
using test::Bytes;
using Seed = std::function<void(const char*, const std::string&, std::span<const std::byte>)>;

constexpr std::size_t kMaxSeed = 4000;  // scripts/fuzz.sh takes inputs of 4096 bytes

Bytes behind(std::uint8_t choice, std::span<const std::byte> bytes) {
  Bytes input{std::byte(choice)};
  input.insert(input.end(), bytes.begin(), bytes.end());
  return input;
}

// The first events and outputs of each node, as far as they go into an input.
void seed_nodes(const Seed& seed) {
  const std::vector<NodeSetup> setups = node_setups();
  for (std::size_t n = 0; n < setups.size(); ++n) {
    const std::string name = std::to_string(n) + "-" + std::string(info(setups[n].id).name);
    seed("fuzz_config_message", name, behind(std::uint8_t(n), as_span(setups[n].run->config_toml)));
    const std::string wal = std::string(info(setups[n].id).name) + ".wal";
    const record::MappedFile file(setups[n].run->folder / "nodes" / wal);
    record::RecordReader reader(file.bytes());
    Bytes input{std::byte(n)};
    std::array<int, 3> seeded{};
    while (const auto record = reader.next()) {
      const std::size_t bytes = record->payload.size();
      const int kind = int(record->kind) - 1;
      if (kind < 0 || kind > 2 || bytes + 3 > kMaxSeed) continue;
      if (seeded[std::size_t(kind)]++ < 2 && bytes < 500)
        seed("fuzz_write_ahead",
             name + "-" + std::to_string(kind) + std::to_string(seeded[std::size_t(kind)]),
             behind(std::uint8_t(kind), record->payload));
      if (input.size() + 3 + bytes > kMaxSeed) break;
      for (const std::size_t v : {std::size_t(kind), bytes & 255, bytes >> 8}) input.push_back(std::byte(v));
      input.insert(input.end(), record->payload.begin(), record->payload.end());
    }
    if (setups[n].id == NodeId::kPathPlanner)
      input[0] = std::byte(n + (255 - n) / setups.size() * setups.size());
    seed("fuzz_restore", name, input);
  }
}

void seed_folders(const Seed& seed) {
  for (const char* name : {"v1-mpc", "v5-ice"}) {
    const std::filesystem::path run = std::filesystem::path(FIRN_SOURCE_DIR) / "tests/replay/golden" / name;
    seed("fuzz_run_documents", name, behind(1, test::read_bytes(run / "provenance.json")));
    seed("fuzz_run_documents", std::string(name) + "-result",
         behind(0, test::read_bytes(run / "result.json")));
    const record::MappedFile file(run / "world.rec");
    record::RecordReader reader(file.bytes());
    Bytes input;
    while (const auto record = reader.next()) {
      const std::size_t bytes = record->payload.size();
      if (bytes > 255) continue;
      if (input.size() + 2 + bytes > 1000) break;
      for (const std::size_t v : {std::size_t(record->kind), bytes}) input.push_back(std::byte(v));
      input.insert(input.end(), record->payload.begin(), record->payload.end());
    }
    seed("fuzz_world_record", name, input);
  }
}

void seed_states(const Seed& seed) {
  const test::Scratch scratch("fuzz-states");
  for (const int ice : {0, 1}) {
    const plant::World world(ice ? small_ice_world() : small_inkjet_world(), nullptr);
    world.save(scratch / "state");
    Bytes state = test::read_bytes(scratch / "state");
    seed("fuzz_world_state", "whole-" + std::to_string(ice), behind(std::uint8_t(ice), state));
    state.resize(state.size() - 8);
    seed("fuzz_world_state", "body-" + std::to_string(ice), behind(std::uint8_t(ice | 2), state));
  }
}

// Grey, 2 x 2, 8 bits, deflated without compression.
void seed_picture(const Seed& seed) {
  static constexpr std::string_view kPng(
      "\x89PNG\r\n\x1a\n"
      "\0\0\0\x0dIHDR\0\0\0\2\0\0\0\2\x08\0\0\0\0....\0\0\0\x11IDAT"
      "\x78\x01\x01\x06\0\xf9\xff\0\x10\x20\0\x30\x40\x01\x76\0\xa1....\0\0\0\0IEND....",
      8 + 25 + 29 + 12);
  seed("fuzz_png", "grey", as_span(kPng));
  seed("fuzz_png", "height-map",
       test::read_bytes(std::filesystem::path(FIRN_SOURCE_DIR) / "experiments/height_map.png"));
}

void seed_meshes(const Seed& seed) {
  namespace mb = test::mesh_bytes;
  const std::string mesh = mb::threemf_mesh(test::gear(1));
  seed("fuzz_3mf", "plain", mb::threemf(test::gear(1)));
  seed(
      "fuzz_3mf", "components",
      mb::threemf_of("<resources><object id=\"1\">" + mesh +
                     "</object><object id=\"2\"><components><component objectid=\"1\" transform=\"-1 0 0 0 1 "
                     "0 0 0 1 15 0 0\"/></components></object></resources><build><item objectid=\"2\" "
                     "printable=\"1\"/></build>"));
  seed("fuzz_3mf", "roles",
       mb::threemf_with("<resources><object id=\"1\">" + mesh +
                            "</object></resources><build><item objectid=\"1\"/></build>",
                        {{"Metadata/Slic3r_PE_model.config",
                          "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"3\"><metadata "
                          "key=\"volume_type\" value=\"ParameterModifier\"/></volume></object></config>"}}));
}

void seed_datagrams(const Seed& seed) {
  Bytes packet(kPacketHead);
  write_packet_head(7, std::span<std::byte, kPacketHead>(packet.data(), kPacketHead));
  const Bytes bytes(40, std::byte{3});
  const auto channel = as_span(std::string_view("HEIGHT_MAP\0", 11));
  packet.insert(packet.end(), channel.begin(), channel.end());
  packet.insert(packet.end(), bytes.begin(), bytes.end());
  seed("fuzz_lcm_packet", "short", packet);
  packet[3] = std::byte('3');
  seed("fuzz_lcm_packet", "fragment", packet);
  relay::Hello hello;
  hello.facts = {1, "1.0.0", "abc", "def", "glibc", "0123456789abcdef", "boot", "bench"};
  hello.order.nodes = {"jet"};
  hello.order.files["experiment.toml"] = {12, "aa"};
  const std::string text = to_json(hello);
  std::vector<std::byte> stream;
  relay::append_frame({relay::FrameKind::kHello, {}, 0, 0, std::as_bytes(std::span(text))}, stream);
  relay::append_frame({relay::FrameKind::kFile, "nodes/jet.wal", 100, 0, packet}, stream);
  seed("fuzz_relay", "hello", stream);
}

void seed_foreign(const Seed& seed) {
  PrintQueue queue;
  QueuedPrint print;
  print.experiment = "/a/part.toml";
  print.overrides = {"part.height_mm=0.1"};
  queue.add(print, false);
  queue.add(print, true);
  queue.begin(2);
  queue.end(2, "runs/r", "the jet is disconnected");
  queue.clear("Ada");
  const std::string queue_text = to_text(queue);
  seed("fuzz_print_queue", "two", as_span(std::string_view(queue_text)));
  seed("fuzz_client_frame", "set",
       as_span(std::string_view(
           R"({"type":"command","id":7,"token":"t","command":"set","key":"a.b","value":"1"})")));
  seed("fuzz_client_frame", "follow",
       as_span(std::string_view(R"({"type":"follow","surface":"error","layer":3})")));
  seed("fuzz_client_frame", "notes",
       as_span(std::string_view(R"({"token":"t","author":"A","add_tags":["a","b"],"note":"x\ny"})")));
  seed("fuzz_client_frame", "path", as_span(std::string_view("/api/runs/a%20b/layers/3/error?x")));
  std::vector<std::uint8_t> disc{40, 40, 0, 0};  // a dark disc on a bright ground, below a nozzle
  for (int y = 0; y < 56; ++y)
    for (int x = 0; x < 56; ++x)
      disc.push_back((x - 28) * (x - 28) + (y - 34) * (y - 34) < 90 || (y < 10 && x > 12 && x < 44) ? 20
                                                                                                    : 190);
  seed("fuzz_droplets", "disc", std::as_bytes(std::span(disc)));
  // A dark line with a gap: along x, aslant, and the same in runs of bytes.
  for (const bool aslant : {false, true}) {
    constexpr int kSide = 60;
    std::vector<std::uint16_t> pixels;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const int across = std::abs(aslant ? (x - y) * 7 / 10 : y - 29), along = aslant ? (x + y) / 2 : x;
        pixels.push_back(std::uint16_t(across < 6 && (along < 26 || along > 34) ? 40 + 5 * across : 190));
      }
    Bytes input;
    for (const int b : {0, 0, 0, 0, 124, 124, 218, aslant ? 1 : 2, 200, 88, 176, 32})
      input.push_back(std::byte(b));
    const std::vector<std::byte> png = write_grey_png(kSide, kSide, 255, pixels);
    const std::size_t head = input.size();
    input.insert(input.end(), png.begin(), png.end());
    seed("fuzz_line_picture", aslant ? "aslant" : "along", input);
    input.resize(head);
    input[0] = std::byte(128);
    input[1] = input[2] = std::byte(kSide - 16);
    for (const std::uint16_t p : pixels) input.push_back(std::byte(p));
    seed("fuzz_line_picture", aslant ? "aslant-runs" : "along-runs", input);
  }
  for (const auto& [name, text] :
       {std::pair<const char*, std::string_view>{"done", "done 7 :Python%203 timeout_s=1.5 safe_bytes=79,10"},
        {"fail", "fail 7 late :psu.py%2c%20line%203"},
        {"write", "write 7 4f4b0a"},
        {"note", "note :warm"},
        {"report", "<Hold:0|MPos:1.000,-2.500,0.000|FS:0,0|WCO:0.000,1.000,0.000>\nok\n"},
        {"setting", "$110=500.000\nok\nerror:9\nALARM:1\n[MSG:Reset]\n"}})
    seed("fuzz_device_lines", name, as_span(text));
  seed("fuzz_cassette", "lamp",
       as_span(std::string_view("firn cassette 1 lamp\n# SIMULATED sim:\n# config: [run]\n       0.500 open\n"
                                "       1.000 > 47 55 53 46 41 0d |GUSFA.|\n       3.000 < 31 38 0d |18.|\n"
                                "       4.000 = LAMP_COMMAND 0a 0b |expose|\n       5.000 = stop |end|\n"
                                "       9.000 closed\n")));
  seed(
      "fuzz_type_texts", "recursive",
      as_span(std::string_view("package a.b; struct node_t { int32_t n; node_t children[n]; double v; }\n"
                               "struct m_t { n_t a[2]; byte k; m_t more[k]; }\n"
                               "struct n_t { int8_t k; a.b.m_t z[k]; string s; boolean b; byte q[0x10]; }")));
  seed("fuzz_type_texts", "twice",
       as_span(std::string_view("package a; struct point_t { double x, y; } struct e_t {}\n"
                                "package b; struct vector_t { double x, y; } struct x_t { what_t w; }")));
  seed("fuzz_layer_record", "points",
       behind(0, as_span(std::string_view("layer,x_mm,y_mm,height_um,drops\n1,0,0,7.5,1\n1,0.5,0,nan,0\n"
                                          "2,0,0,15.25,1\n2,0.5,0,,\n"))));
  seed(
      "fuzz_layer_record", "segments",
      behind(3, as_span(std::string_view("# made by a robot\nLayer;Segment;Increment [mil];Input\n1;1;1,5;2\n"
                                         "1;2;-;3\n2;1;1,25;NA\n"))));
  seed("fuzz_layer_record", "matrices",
       behind(4 + 16, as_span(std::string_view("1;2,5;-\n3;nan\n1;0;0\n1;1;2\n"))));
  Bytes layers = to_npy(HeightMap({3, 2, 1, 1, 0, 0}, 0.25));
  Bytes second(layers.size(), std::byte{'\n'});  // as long: the halves are the layers
  second.front() = std::byte{'7'};
  layers.insert(layers.end(), second.begin(), second.end());
  seed("fuzz_layer_record", "npy", behind(1 + 4 + 8, layers));
  // As Java's lcm.logging.Log writes: every event has the number 0.
  Bytes log;
  for (int k = 0; k < 4; ++k) {
    const std::size_t at = log.size();
    log.resize(at + record::kEventHeaderBytes + 9, std::byte{std::uint8_t(k)});
    record::put_event_header(log.data() + at, {0, 0, 1000 * k, 1, 8});
    log[at + record::kEventHeaderBytes] = std::byte{'A'};
  }
  Bytes input(4);
  const auto split = std::uint32_t(log.size());
  std::memcpy(input.data(), &split, 4);
  input.insert(input.end(), log.begin(), log.end());
  seed("fuzz_event_log", "java", input);
}

}  // namespace

void seed_runs(const Seed& seed) {
  seed_foreign(seed);
  seed_nodes(seed);
  seed_folders(seed);
  seed_states(seed);
  seed_picture(seed);
  seed_meshes(seed);
  seed_datagrams(seed);
  seed("fuzz_study_journal", "print",
       behind(
           1,
           as_span(R"({"digest":"","finished":true,"outcome":"finished","reason":"","cpu_s":1.5,"metrics":{)"
                   R"("rms_um":1.0,"std_um":null,"abs_mean_um":0,"mean_abs_um":0,"max_um":0,"layers":4,)"
                   R"("droplets":9,"print_s":1,"iterations":1},"profile":[[1,2],[3,4]]})")));
  seed("fuzz_study_journal", "simulated print",
       behind(1, as_span(R"({"digest":"","finished":true,"reason":"","metrics":[1.0,null],"features":[0.5],)"
                         R"("traits":[0,0.1,-0.2,0]})")));
}

}  // namespace firn::fuzz
