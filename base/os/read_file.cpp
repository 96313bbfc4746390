// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/read_file.hpp"

#include <fcntl.h>

#include <array>
#include <cerrno>

#include "base/os/descriptor.hpp"

namespace cas::base {

std::optional<std::string> read_file(const std::filesystem::path& file) {
  const Descriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!in) return std::nullopt;
  std::string text;
  std::array<char, 65536> part{};
  for (;;) {
    const ssize_t size = ::read(in.get(), part.data(), part.size());
    if (size == 0) return text;
    if (size > 0) {
      text.append(part.data(), static_cast<std::size_t>(size));
    } else if (errno != EINTR) {
      return std::nullopt;
    }
  }
}

}  // namespace cas::base
