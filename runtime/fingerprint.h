// A fingerprint of results tells of each library function whether it gives the same bytes on this computer:
// it holds the digest of the function's values at fixed arguments. CPU flags and versions say less: a library
// chooses among variants of a function at run time, and unlike CPUs may agree.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace firn {

/// Digest (XXH64 over little-endian bytes) of each function's values, by its name: "exp", "cv::dct".
using Fingerprint = std::map<std::string, std::uint64_t>;

/// One number for all of it: equal where every function gives the same bytes.
std::uint64_t digest_of(const Fingerprint& fingerprint);

/// Returns the functions of both that differ, by name. A function that one of them lacks is not compared.
std::vector<std::string> differing_functions(const Fingerprint& a, const Fingerprint& b);

/// As provenance.json keeps it: {"exp": "0123456789abcdef", …} as text, and back.
/// @throws std::invalid_argument naming the function whose digest is no 16 hexadecimal digits
std::map<std::string, std::string> fingerprint_texts(const Fingerprint& fingerprint);
Fingerprint fingerprint_of(const std::map<std::string, std::string>& texts);

}  // namespace firn
