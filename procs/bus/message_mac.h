// MessageMac and MacVerifier authenticate the messages of a run by a trailer behind the encoded message:
// sender, number, and a message authentication code (MAC) of channel, message, sender and number: GMAC of
// AES-256 [NIST SP 800-38D]; on the channels of the lab's own programs the keyed hash BLAKE2b-128 [RFC 7693],
// which every language's library has. LCM's decoders ignore bytes behind a message, so that lcm-spy and
// lcm-logger still read.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "procs/bus/bus_key.h"

struct evp_cipher_ctx_st;
struct evp_mac_ctx_st;

namespace firn {

inline constexpr std::size_t kMacTrailerBytes = 32;  ///< sender 8, number 8, hash 16; big endian

/// The numbers in a trailer: who sent the message, and its how-manieth it is.
struct MacNumbers {
  std::uint64_t sender = 0, number = 0;
};
MacNumbers mac_numbers(std::span<const std::byte, kMacTrailerBytes> trailer);

/// Computes the hash with one key; not for two threads at once.
class KeyedHash {
 public:
  static constexpr std::size_t kBytes = 16;
  /// @throws std::runtime_error if this OpenSSL has no BLAKE2b
  explicit KeyedHash(const BusKey& key);
  void compute(std::string_view channel, std::span<const std::byte> message,
               std::span<const std::byte, 16> sender_and_number, std::span<std::byte, kBytes> to);

 private:
  struct Free {
    void operator()(evp_mac_ctx_st* context) const;
  };
  std::unique_ptr<evp_mac_ctx_st, Free> context_;
};

/// Computes GMAC with a key derived from the run's, ten times as fast as KeyedHash for large messages; not
/// for two threads at once. No two messages of one key may have the same sender and number, its nonce.
class KeyedCode {
 public:
  static constexpr std::size_t kBytes = KeyedHash::kBytes;
  /// @throws std::runtime_error if this OpenSSL has no AES-256-GCM
  explicit KeyedCode(const BusKey& key);
  void compute(std::string_view channel, std::span<const std::byte> message,
               std::span<const std::byte, 16> sender_and_number, std::span<std::byte, kBytes> to);

 private:
  struct Free {
    void operator()(evp_cipher_ctx_st* context) const;
  };
  std::unique_ptr<evp_cipher_ctx_st, Free> context_;
};

/// Returns the key of one of the lab's own programs: it authenticates messages on that program's channels and
/// on no others. Without the run's key it cannot be computed.
BusKey own_key(const BusKey& run, std::string_view program);

/// Computes the trailers of one sender, whose random number no other sender of the run has.
class MessageMac {
 public:
  explicit MessageMac(const BusKey& key);
  void write(std::string_view channel, std::span<const std::byte> message,
             std::span<std::byte, kMacTrailerBytes> trailer);

 private:
  KeyedCode code_;
  KeyedHash hash_;  // of an own program
  std::uint64_t sender_;
  std::uint64_t number_ = 0;
};

enum class MacFault : std::uint8_t {
  kNone,
  kForged,    ///< without a trailer, or not by a holder of the key, or altered
  kRepeated,  ///< taken before, or older than what can still be told from it
};

/// Checks trailers. Of each sender the numbers are taken once, in any order within kWindow [RFC 4303,
/// section 3.4.3]: on the way to another host stops and heartbeats overtake thousands of others. A channel
/// of one of the lab's own programs has that program's key.
class MacVerifier {
 public:
  explicit MacVerifier(const BusKey& key) : key_(key), run_(key) {}
  /// Cuts the trailer from `datagram` if there is no fault.
  MacFault open(std::string_view channel, std::span<const std::byte>& datagram);

  static constexpr std::size_t kWindow = 8192;

 private:
  struct Seen {
    std::uint64_t newest = 0;
    std::bitset<kWindow> taken;  // bit number mod kWindow, of newest - kWindow + 1 to newest
    bool take(std::uint64_t number);
  };
  /// What a key's holders have sent. No program can use up the numbers of another, or of the run's processes.
  template <class Code>
  struct Holders {
    explicit Holders(const BusKey& key) : code(key) {}
    MacFault open(std::string_view channel, std::span<const std::byte>& datagram, std::size_t most_senders);
    Code code;
    std::map<std::uint64_t, Seen> senders;
  };
  BusKey key_;
  Holders<KeyedCode> run_;
  std::map<std::string, Holders<KeyedHash>, std::less<>>
      own_;  // by program, once it has sent one with its MAC
};

}  // namespace firn
