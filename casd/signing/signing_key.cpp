// SPDX-License-Identifier: BSD-3-Clause
#include "casd/signing/signing_key.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "base/rpc/token.hpp"

namespace cas::casd {
namespace {

constexpr std::string_view kHexDigits = "0123456789abcdefABCDEF";

bool is_hex_key(std::string_view line) {
  return line.size() == 2 * mav::SigningKey{}.size() &&
         line.find_first_not_of(kHexDigits) == std::string_view::npos;
}

mav::SigningKey from_hex(std::string_view digits) {
  mav::SigningKey key{};
  for (std::size_t i = 0; i < key.size(); ++i) {
    std::from_chars(digits.data() + 2 * i, digits.data() + 2 * i + 2, key[i], 16);
  }
  return key;
}

/// "/etc/cas/radio.key" -> "etc_cas_radio.key.time": keys of one name in two folders stay apart.
std::string flat_name(const std::filesystem::path& file) {
  std::string name = std::filesystem::absolute(file).lexically_normal().string().substr(1);
  std::replace(name.begin(), name.end(), '/', '_');
  return name + ".time";
}

}  // namespace

mav::SigningKey read_signing_key(const std::filesystem::path& file) {
  const std::string line = base::rpc::read_token(file);
  return is_hex_key(line) ? from_hex(line) : mav::signing_key(line);
}

SigningTimeFile::SigningTimeFile(const std::filesystem::path& key_file) {
  const char* state = std::getenv("STATE_DIRECTORY");
  if (state != nullptr && *state != '\0') {
    path_ = std::filesystem::path(state) / flat_name(key_file);
  } else {
    path_ = key_file.string() + ".time";
  }
}

mav::SigningTime SigningTimeFile::load() const {
  std::ifstream in(path_);
  mav::SigningTime bound = 0;
  return in >> bound && bound <= mav::kMaxSigningTime ? bound : 0;
}

bool SigningTimeFile::store(mav::SigningTime bound) const {
  try {
    // Whoever stores holds the lock of the packets: no waiting for a disk.
    base::write_file(path_, std::to_string(bound) + "\n", base::Durability::kCache);
  } catch (const base::ConfigError&) {
    return false;
  }
  return true;
}

}  // namespace cas::casd
