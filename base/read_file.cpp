// SPDX-License-Identifier: BSD-3-Clause
#include "base/read_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <limits>
#include <utility>

#include "base/error.hpp"

namespace cas::base {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, std::string_view kind,
                       const std::string& sentence) {
  throw ConfigError(file.string() + ": " + std::string(kind) + " " + sentence);
}

std::string size_text(std::size_t bytes) {
  constexpr std::size_t kMiB = std::size_t{1} << 20U;
  return bytes >= kMiB ? std::to_string(bytes / kMiB) + " MiB" : std::to_string(bytes) + " bytes";
}

/// Reads on to the end, or to at most one piece beyond `most_bytes`. @return nullopt: reading
/// failed
std::optional<std::string> rest_of(std::FILE& in, std::size_t most_bytes) {
  std::string text;
  std::array<char, 65536> part{};
  while (text.size() <= most_bytes) {
    const std::size_t size = std::fread(part.data(), 1, part.size(), &in);
    if (size == 0) break;
    text.append(part.data(), size);
  }
  if (std::ferror(&in) != 0) return std::nullopt;
  return text;
}

[[noreturn]] void fail_larger(const std::filesystem::path& file, std::string_view kind,
                              std::size_t most_bytes) {
  fail(file, kind, "is larger than the " + size_text(most_bytes) + " that are read");
}

OpenFile open_foreign_file(const std::filesystem::path& file, std::string_view kind,
                           std::size_t most_bytes) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  OpenFile opened(fd < 0 ? nullptr : ::fdopen(fd, "rb"));
  if (!opened && fd >= 0) ::close(fd);
  struct stat status {};
  if (!opened || ::fstat(fd, &status) != 0) fail(file, kind, "cannot be read");
  if (S_ISDIR(status.st_mode)) fail(file, kind, "is a folder, not a file");
  if (!S_ISREG(status.st_mode)) fail(file, kind, "is no regular file");
  if (static_cast<std::uintmax_t>(status.st_size) > most_bytes) {
    fail_larger(file, kind, most_bytes);
  }
  return opened;
}

}  // namespace

std::optional<std::string> read_file(const std::filesystem::path& file) {
  const OpenFile in(std::fopen(file.c_str(), "rbe"));
  if (!in) return std::nullopt;
  return rest_of(*in, std::numeric_limits<std::size_t>::max());
}

OpenFile open_foreign_file(const std::filesystem::path& file, std::string_view kind) {
  return open_foreign_file(file, kind, std::numeric_limits<std::size_t>::max());
}

std::string read_foreign_file(const std::filesystem::path& file, std::string_view kind,
                              std::size_t most_bytes) {
  const OpenFile opened = open_foreign_file(file, kind, most_bytes);
  std::optional<std::string> text = rest_of(*opened, most_bytes);
  if (!text) fail(file, kind, "cannot be read");
  if (text->size() > most_bytes)
    fail_larger(file, kind, most_bytes);  // the file has grown meanwhile
  return std::move(*text);
}

}  // namespace cas::base
