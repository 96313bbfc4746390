// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/token.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>

#include "base/byte_order_mark.hpp"
#include "base/error.hpp"
#include "base/os/descriptor.hpp"
#include "base/os/runtime_folder.hpp"
#include "base/os/trusted_file.hpp"
#include "base/rpc/local_port.hpp"

namespace cas::base::rpc {
namespace {

constexpr std::size_t kShortestToken = 16;
constexpr std::size_t kLongestToken = 4096;
constexpr std::size_t kMadeBytes = 32;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& sentence) {
  throw ConfigError(file.string() + ": " + sentence);
}

/// Whether a secret's file belongs to root, to this user or, in the service's folders, to the
/// service's user. Any other owner would know the secret.
bool is_made_by_friend(uid_t owner, const std::filesystem::path& file) {
  if (owner == 0 || owner == ::geteuid()) return true;
  const std::filesystem::path folder = file.parent_path();
  struct stat service {};
  return (folder == kServiceFolder || folder == kServiceState) &&
         ::lstat(folder.c_str(), &service) == 0 && service.st_uid == owner;
}

/// Reads from the descriptor whose rights were checked: the path may change meanwhile.
std::string read_checked(int fd, const std::filesystem::path& file) {
  struct stat status {};
  if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) fail(file, "is no regular file");
  if (!is_made_by_friend(status.st_uid, file)) {
    fail(file, "belongs to another user, who knows the secret; make it anew");
  }
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    fail(file, "holds a secret that others may read or change; set its mode to 0600");
  }
  std::array<char, kLongestToken> buffer;
  const ssize_t size = ::read(fd, buffer.data(), buffer.size());
  if (size < 0) fail(file, error_text(errno));
  const std::string_view text =
      without_byte_order_mark({buffer.data(), static_cast<std::size_t>(size)});
  return std::string(text.substr(0, text.find_first_of("\r\n")));
}

/// A fresh secret and a newline. @return errno, 0 when all is written
int write_token(int fd) {
  std::array<unsigned char, kMadeBytes> random;
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
    return errno;
  }
  std::string text;
  for (const unsigned char byte : random) {
    text += "0123456789abcdef"[byte >> 4U];
    text += "0123456789abcdef"[byte & 15U];
  }
  text += '\n';
  const ssize_t written = ::write(fd, text.data(), text.size());
  if (written < 0) return errno;
  if (static_cast<std::size_t>(written) != text.size()) return ENOSPC;
  return ::fsync(fd) == 0 ? 0 : errno;  // no power cut leaves a file without its secret
}

}  // namespace

std::string read_token(const std::filesystem::path& file) {
  const Descriptor fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!fd) fail(file, error_text(errno));
  require_kept_folders(file);
  std::string token = read_checked(fd.get(), file);
  if (token.size() < kShortestToken) fail(file, "the token has fewer than 16 characters");
  return token;
}

bool make_token(const std::filesystem::path& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) == 0) return false;
  // Written beside it and linked: another program never reads half of it, and link() replaces no
  // existing file.
  const std::string beside = file.string() + "." + std::to_string(::getpid()) + ".new";
  ::unlink(beside.c_str());  // of a program with this number that was killed here
  Descriptor out(
      ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!out) fail(file, "cannot be made: " + error_text(errno));
  const int error = write_token(out.get());
  const bool made = error == 0 && ::link(beside.c_str(), file.c_str()) == 0;
  const int not_linked = errno;
  ::unlink(beside.c_str());
  if (made) return true;
  if (error == 0 && not_linked == EEXIST) return false;  // another program was faster
  fail(file, "cannot be made: " + error_text(error != 0 ? error : not_linked));
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
