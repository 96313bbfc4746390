// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/token.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"

namespace cas::base::rpc {
namespace {

constexpr std::size_t kShortestToken = 16;
constexpr std::size_t kLongestToken = 4096;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& sentence) {
  throw ConfigError(file.string() + ": " + sentence);
}

/// Reads from the descriptor whose rights were checked: the path may change meanwhile.
std::string read_checked(int fd, const std::filesystem::path& file) {
  struct stat status {};
  if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) fail(file, "is no regular file");
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    fail(file, "holds a secret that others may read or change; set its mode to 0600");
  }
  std::array<char, kLongestToken> buffer;
  const ssize_t size = ::read(fd, buffer.data(), buffer.size());
  if (size < 0) fail(file, std::generic_category().message(errno));
  const std::string text(buffer.data(), static_cast<std::size_t>(size));
  return text.substr(0, text.find_first_of("\r\n"));
}

}  // namespace

std::string read_token(const std::filesystem::path& file) {
  const Descriptor fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!fd) fail(file, std::generic_category().message(errno));
  std::string token = read_checked(fd.get(), file);
  if (token.size() < kShortestToken) fail(file, "the token has fewer than 16 characters");
  return token;
}

bool same_token(std::string_view expected, std::string_view given) {
  unsigned difference = expected.size() == given.size() ? 0 : 1;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const char against = expected.empty() ? '\0' : expected[i % expected.size()];
    difference |= static_cast<unsigned char>(given[i] ^ against);
  }
  return difference == 0;
}

}  // namespace cas::base::rpc
