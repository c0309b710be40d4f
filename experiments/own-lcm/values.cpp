// A program of the lab's own in C++ on stock LCM: publishes one number a second in a running print.
//
//   lcm-gen -x --cpp-hpath . lcmtypes/header_t.lcm lcmtypes/own_values_t.lcm
//   g++ -std=c++17 -I. experiments/own-lcm/values.cpp -o values -llcm -lcrypto
//   firn key runs/RUN --as barometer --json | ./values 10
#include <openssl/core_names.h>
#include <openssl/evp.h>
#include <openssl/params.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "firn/own_values_t.hpp"

using Bytes = std::vector<unsigned char>;

// Behind the message stand sender, number, and BLAKE2b-128 of channel, message, sender and number under the
// key.
Bytes seal(const Bytes& key, const std::string& channel, Bytes message, std::uint64_t sender,
           std::uint64_t number) {
  for (const std::uint64_t v : {sender, number})
    for (int shift = 56; shift >= 0; shift -= 8) message.push_back((unsigned char)(v >> shift));
  std::size_t size = 16;
  const OSSL_PARAM options[] = {OSSL_PARAM_construct_size_t(OSSL_MAC_PARAM_SIZE, &size),
                                OSSL_PARAM_construct_end()};
  unsigned char code[16];
  EVP_MAC* const mac = EVP_MAC_fetch(nullptr, OSSL_MAC_NAME_BLAKE2BMAC, nullptr);
  EVP_MAC_CTX* const context = EVP_MAC_CTX_new(mac);
  const auto* const name = reinterpret_cast<const unsigned char*>(channel.c_str());
  if (!EVP_MAC_init(context, key.data(), key.size(), options) ||
      !EVP_MAC_update(context, name, channel.size() + 1) ||
      !EVP_MAC_update(context, message.data(), message.size()) ||
      !EVP_MAC_final(context, code, &size, sizeof code))
    std::exit(1);
  EVP_MAC_CTX_free(context);
  EVP_MAC_free(mac);
  message.insert(message.end(), code, code + size);
  return message;
}

// The text behind "name": in the admission; a program with more to read takes a JSON library.
std::string text_of(const std::string& json, const std::string& name) {
  const std::size_t at = json.find('"', json.find("\"" + name + "\":") + name.size() + 3) + 1;
  return json.substr(at, json.find('"', at) - at);
}

int main(int argc, char** argv) {
  const std::string admission((std::istreambuf_iterator<char>(std::cin)), {});
  const std::string key_text = text_of(admission, "key"), program = text_of(admission, "program");
  Bytes key;
  for (std::size_t n = 0; n + 1 < key_text.size(); n += 2)
    key.push_back((unsigned char)std::stoul(key_text.substr(n, 2), nullptr, 16));
  lcm::LCM bus(text_of(admission, "bus").substr(0, text_of(admission, "bus").find('&')));
  if (!bus.good() || key.empty()) {
    std::fprintf(stderr, "values: the output of firn key RUN --json is wanted on standard input\n");
    return 2;
  }
  const std::uint64_t sender = std::random_device{}() * 4294967296ull + std::random_device{}();
  const std::string channel = "own/" + program + "/OWN_VALUES";
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 10;
  for (int n = 1; n <= seconds; ++n) {
    firn::own_values_t m{};
    m.name = "air pressure";
    m.unit = "hPa";
    m.values = {1013.25 + 0.1 * n};  // of an instrument
    m.n = 1;
    Bytes bytes(std::size_t(m.getEncodedSize()));
    m.encode(bytes.data(), 0, int(bytes.size()));
    const Bytes sealed = seal(key, channel, bytes, sender, std::uint64_t(n));
    bus.publish(channel, sealed.data(), unsigned(sealed.size()));
    std::this_thread::sleep_for(std::chrono::seconds(n < seconds));
  }
}
