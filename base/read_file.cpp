// SPDX-License-Identifier: BSD-3-Clause
#include "base/read_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>

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

}  // namespace

std::optional<std::string> read_file(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rbe"),
                                                           std::fclose);
  if (!in) return std::nullopt;
  std::string text;
  std::array<char, 65536> part{};
  while (const std::size_t size = std::fread(part.data(), 1, part.size(), in.get())) {
    text.append(part.data(), size);
  }
  if (std::ferror(in.get()) != 0) return std::nullopt;
  return text;
}

Descriptor open_foreign_file(const std::filesystem::path& file, std::string_view kind) {
  Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat status {};
  if (!opened || ::fstat(opened.get(), &status) != 0) fail(file, kind, "cannot be read");
  if (S_ISDIR(status.st_mode)) fail(file, kind, "is a folder, not a file");
  if (!S_ISREG(status.st_mode)) fail(file, kind, "is no regular file");
  return opened;
}

std::string read_foreign_file(const std::filesystem::path& file, std::string_view kind,
                              std::size_t most_bytes) {
  const Descriptor opened = open_foreign_file(file, kind);
  std::string text;
  std::array<char, 65536> part{};
  for (;;) {
    const ssize_t size = ::read(opened.get(), part.data(), part.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) fail(file, kind, "cannot be read");
    if (size == 0) return text;
    text.append(part.data(), static_cast<std::size_t>(size));
    if (text.size() > most_bytes) {
      fail(file, kind, "is larger than the " + size_text(most_bytes) + " that are read");
    }
  }
}

}  // namespace cas::base
