// SPDX-License-Identifier: BSD-3-Clause
#include "base/read_file.hpp"

#include <array>
#include <cstdio>
#include <memory>

namespace cas::base {

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

}  // namespace cas::base
