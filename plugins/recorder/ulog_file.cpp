// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/recorder/ulog_file.hpp"

#include <bit>
#include <cerrno>
#include <string>

namespace cas::sim {
namespace {

static_assert(std::endian::native == std::endian::little, "ULog is little-endian");

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

template <class T>
std::array<std::uint8_t, sizeof(T)> bytes_of_number(T value) {
  return std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
}

[[noreturn]] void fail(const std::filesystem::path& path, const char* what) {
  throw base::ConfigError(path.string() + ": " + what + ": " + std::strerror(errno));
}

}  // namespace

UlogFile::UlogFile(const std::filesystem::path& file, std::span<const UlogTopic> topics)
    : path_(file) {
  std::error_code ignored;  // opening says what is wrong
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  file_.reset(std::fopen(file.c_str(), "wbe"));
  if (!file_) fail(path_, "cannot be written");
  write_header();
  write_info("char[3] sys_name", "CAS");
  for (const UlogTopic& topic : topics) {
    const std::string format =
        std::string(topic.name).append(":uint64_t timestamp;").append(topic.fields).append(";");
    write_message('F', bytes_of(format), {});
  }
  for (std::size_t id = 0; id < topics.size(); ++id) {
    const auto low = static_cast<std::uint8_t>(id & 0xFFU);
    const auto high = static_cast<std::uint8_t>(id >> 8U);
    write_message('A', std::array<std::uint8_t, 3>{0, low, high}, bytes_of(topics[id].name));
  }
}

void UlogFile::write_header() {
  constexpr std::array<std::uint8_t, 8> kMagicAndVersion{'U',  'L',  'o',  'g',
                                                         0x01, 0x12, 0x35, 0x01};
  constexpr std::array<std::uint8_t, 8> kStart{};     // the log begins at time zero
  constexpr std::array<std::uint8_t, 40> kNoFlags{};  // nothing appended, nothing special
  std::fwrite(kMagicAndVersion.data(), 1, kMagicAndVersion.size(), file_.get());
  std::fwrite(kStart.data(), 1, kStart.size(), file_.get());
  write_message('B', kNoFlags, {});
}

void UlogFile::write_info(std::string_view key, std::string_view value) {
  std::string body(1, static_cast<char>(key.size()));
  body.append(key).append(value);
  write_message('I', bytes_of(body), {});
}

void UlogFile::write(std::uint16_t topic, const UlogRecord& record) {
  write_message('D', bytes_of_number(topic), record.bytes());
}

void UlogFile::write_message(char type, std::span<const std::uint8_t> head,
                             std::span<const std::uint8_t> body) {
  const auto size = bytes_of_number(static_cast<std::uint16_t>(head.size() + body.size()));
  std::fwrite(size.data(), 1, size.size(), file_.get());
  std::fputc(type, file_.get());
  for (const auto part : {head, body}) {
    if (!part.empty()) std::fwrite(part.data(), 1, part.size(), file_.get());
  }
}

void UlogFile::close() {
  if (!file_) return;
  const bool written = std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0;
  file_.reset();
  if (!written) fail(path_, "was not written to its end");
}

}  // namespace cas::sim
