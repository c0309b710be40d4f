#include "procs/bus/message_mac.h"

#include <openssl/core_names.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/params.h>
#include <sys/random.h>

#include <array>
#include <stdexcept>
#include <utility>

namespace firn {
namespace {

constexpr std::size_t kNumbersBytes = 16;            // sender and number
constexpr std::size_t kAnyNumber = ~std::size_t(0);  // of senders: the run's processes have the key alone
// A program that starts anew is a new sender; numbers of 256 senders take 0.3 MB.
constexpr std::size_t kOwnSenders = 256, kOwnPrograms = 256;
static_assert(kMacTrailerBytes == kNumbersBytes + KeyedHash::kBytes);

/// Returns a key for one purpose, from which `key` cannot be computed.
BusKey derived(const BusKey& key, std::string_view purpose) {
  KeyedHash hash(key);
  BusKey of;
  for (std::size_t half = 0; half < 2; ++half) {
    std::array<std::byte, kNumbersBytes> number{};
    number.back() = std::byte(half);
    hash.compute(purpose, {}, number,
                 std::span(of.bytes).subspan(half * KeyedHash::kBytes).first<KeyedHash::kBytes>());
  }
  return of;
}

void put(std::uint64_t v, std::byte* to) {
  for (int k = 0; k < 8; ++k) to[k] = std::byte(v >> (56 - 8 * k));
}

std::uint64_t number_at(const std::byte* from) {
  std::uint64_t v = 0;
  for (int k = 0; k < 8; ++k) v = v << 8 | std::uint64_t(from[k]);
  return v;
}

const unsigned char* raw(const void* p) { return static_cast<const unsigned char*>(p); }

}  // namespace

MacNumbers mac_numbers(std::span<const std::byte, kMacTrailerBytes> trailer) {
  return {number_at(trailer.data()), number_at(trailer.data() + 8)};
}

void KeyedHash::Free::operator()(evp_mac_ctx_st* context) const { EVP_MAC_CTX_free(context); }

KeyedHash::KeyedHash(const BusKey& key) {
  EVP_MAC* mac = EVP_MAC_fetch(nullptr, OSSL_MAC_NAME_BLAKE2BMAC, nullptr);
  context_.reset(mac ? EVP_MAC_CTX_new(mac) : nullptr);
  EVP_MAC_free(mac);
  std::size_t size = kBytes;
  const OSSL_PARAM options[] = {OSSL_PARAM_construct_size_t(OSSL_MAC_PARAM_SIZE, &size),
                                OSSL_PARAM_construct_end()};
  if (!context_ || EVP_MAC_init(context_.get(), raw(key.bytes.data()), key.bytes.size(), options) != 1)
    throw std::runtime_error("BLAKE2b with a key is not available in this OpenSSL");
}

void KeyedHash::compute(std::string_view channel, std::span<const std::byte> message,
                        std::span<const std::byte, 16> sender_and_number, std::span<std::byte, kBytes> to) {
  EVP_MAC_CTX* c = context_.get();
  const unsigned char end = 0;  // of the channel: no other channel and message have the same bytes
  std::size_t size = 0;
  if (EVP_MAC_init(c, nullptr, 0, nullptr) != 1 ||
      EVP_MAC_update(c, raw(channel.data()), channel.size()) != 1 || EVP_MAC_update(c, &end, 1) != 1 ||
      EVP_MAC_update(c, raw(message.data()), message.size()) != 1 ||
      EVP_MAC_update(c, raw(sender_and_number.data()), sender_and_number.size()) != 1 ||
      EVP_MAC_final(c, reinterpret_cast<unsigned char*>(to.data()), &size, to.size()) != 1 || size != kBytes)
    throw std::runtime_error("BLAKE2b with a key failed in OpenSSL");
}

void KeyedCode::Free::operator()(evp_cipher_ctx_st* context) const { EVP_CIPHER_CTX_free(context); }

KeyedCode::KeyedCode(const BusKey& key) : context_(EVP_CIPHER_CTX_new()) {
  const BusKey of = derived(key, "AES-256-GMAC");
  EVP_CIPHER_CTX* c = context_.get();
  if (!c || EVP_EncryptInit_ex(c, EVP_aes_256_gcm(), nullptr, nullptr, nullptr) != 1 ||
      EVP_CIPHER_CTX_ctrl(c, EVP_CTRL_AEAD_SET_IVLEN, int(kNumbersBytes), nullptr) != 1 ||
      EVP_EncryptInit_ex(c, nullptr, nullptr, raw(of.bytes.data()), nullptr) != 1)
    throw std::runtime_error("AES-256-GCM is not available in this OpenSSL");
}

// The channel ends with a zero: no other channel and message have the same bytes.
void KeyedCode::compute(std::string_view channel, std::span<const std::byte> message,
                        std::span<const std::byte, 16> sender_and_number, std::span<std::byte, kBytes> to) {
  EVP_CIPHER_CTX* c = context_.get();
  const unsigned char end = 0;
  int written = 0;
  if (EVP_EncryptInit_ex(c, nullptr, nullptr, nullptr, raw(sender_and_number.data())) != 1 ||
      EVP_EncryptUpdate(c, nullptr, &written, raw(channel.data()), int(channel.size())) != 1 ||
      EVP_EncryptUpdate(c, nullptr, &written, &end, 1) != 1 ||
      (!message.empty() &&
       EVP_EncryptUpdate(c, nullptr, &written, raw(message.data()), int(message.size())) != 1) ||
      EVP_EncryptFinal_ex(c, nullptr, &written) != 1 ||
      EVP_CIPHER_CTX_ctrl(c, EVP_CTRL_AEAD_GET_TAG, int(to.size()), to.data()) != 1)
    throw std::runtime_error("AES-256-GCM failed in OpenSSL");
}

MessageMac::MessageMac(const BusKey& key) : code_(key), hash_(key) {
  if (::getrandom(&sender_, sizeof sender_, 0) != ssize_t(sizeof sender_))
    throw std::runtime_error("getrandom, for the number of a sender on the bus, failed");
}

void MessageMac::write(std::string_view channel, std::span<const std::byte> message,
                       std::span<std::byte, kMacTrailerBytes> trailer) {
  put(sender_, trailer.data());
  put(++number_, trailer.data() + 8);
  const auto numbers = trailer.first<kNumbersBytes>();
  const auto to = trailer.last<KeyedHash::kBytes>();
  if (channel.starts_with(kOwnPrefix))
    hash_.compute(channel, message, numbers, to);
  else
    code_.compute(channel, message, numbers, to);
}

bool MacVerifier::Seen::take(std::uint64_t number) {
  if (number > newest) {
    if (number - newest >= kWindow)
      taken.reset();
    else
      for (std::uint64_t n = newest + 1; n < number; ++n) taken.reset(n % kWindow);
    newest = number;
  } else if (newest - number >= kWindow || taken.test(number % kWindow)) {
    return false;
  }
  taken.set(number % kWindow);
  return true;
}

BusKey own_key(const BusKey& run, std::string_view program) {
  return derived(run, std::string(kOwnPrefix) + std::string(program));
}

MacFault MacVerifier::open(std::string_view channel, std::span<const std::byte>& datagram) {
  if (!channel.starts_with(kOwnPrefix)) return run_.open(channel, datagram, kAnyNumber);
  const std::string_view program = own_program_of(channel);
  if (program.empty()) return MacFault::kForged;
  if (const auto known = own_.find(program); known != own_.end())
    return known->second.open(channel, datagram, kOwnSenders);
  if (own_.size() >= kOwnPrograms) return MacFault::kForged;
  Holders<KeyedHash> holders(own_key(key_, program));
  const MacFault fault = holders.open(channel, datagram, kOwnSenders);
  if (fault == MacFault::kNone) own_.emplace(program, std::move(holders));
  return fault;
}

template <class Code>
MacFault MacVerifier::Holders<Code>::open(std::string_view channel, std::span<const std::byte>& datagram,
                                          std::size_t most_senders) {
  if (datagram.size() < kMacTrailerBytes) return MacFault::kForged;
  const auto message = datagram.first(datagram.size() - kMacTrailerBytes);
  const auto trailer = datagram.last<kMacTrailerBytes>();
  std::byte wanted[Code::kBytes];
  code.compute(channel, message, trailer.first<kNumbersBytes>(), wanted);
  if (CRYPTO_memcmp(wanted, trailer.data() + kNumbersBytes, sizeof wanted) != 0) return MacFault::kForged;
  const auto [sender, number] = mac_numbers(trailer);
  if (senders.size() >= most_senders && !senders.contains(sender)) return MacFault::kForged;
  if (!senders[sender].take(number)) return MacFault::kRepeated;
  datagram = message;
  return MacFault::kNone;
}

}  // namespace firn
