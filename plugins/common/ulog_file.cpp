// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/ulog_file.hpp"

#include <bit>
#include <cstdio>
#include <string>
#include <utility>

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

template <class T>
std::string text_of_number(T value) {
  const auto bytes = bytes_of_number(value);
  return {bytes.begin(), bytes.end()};
}

std::string key_of(const char* type, std::string_view name) {
  return std::string(type).append(" ").append(name);
}

}  // namespace

std::string wing_fields(int surfaces) {
  std::string fields = "float alpha_rad;float beta_rad;float load_factor";
  if (surfaces > 0) fields += ";float[" + std::to_string(surfaces) + "] deflection_rad";
  return fields;
}

UlogInfo UlogInfo::text(std::string_view name, std::string_view value) {
  const std::string type = "char[" + std::to_string(value.size()) + "]";
  return {key_of(type.c_str(), name), std::string(value)};
}

UlogInfo UlogInfo::int32(std::string_view name, std::int32_t value) {
  return {key_of("int32_t", name), text_of_number(value)};
}

UlogInfo UlogInfo::uint32(std::string_view name, std::uint32_t value) {
  return {key_of("uint32_t", name), text_of_number(value)};
}

UlogFile::UlogFile(base::ResultPlace place, std::span<const UlogTopic> topics,
                   std::span<const UlogInfo> infos, std::span<const UlogParam> params)
    : file_(base::open_result(place)), place_(std::move(place)) {
  write_header();
  const UlogInfo name = UlogInfo::text("sys_name", "CAS");
  write_pair('I', name.key, name.value);
  for (const UlogInfo& info : infos) write_pair('I', info.key, info.value);
  for (const UlogTopic& topic : topics) {
    if (topic.fields.empty()) continue;
    const std::string format =
        std::string(topic.name).append(":uint64_t timestamp;").append(topic.fields).append(";");
    write_message('F', bytes_of(format), {});
  }
  for (const UlogParam& param : params) write(param);
  for (std::size_t id = 0; id < topics.size(); ++id) {
    if (topics[id].fields.empty()) continue;
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

void UlogFile::write_pair(char type, std::string_view key, std::string_view value) {
  CAS_CHECK(key.size() <= 255);  // its length is one byte
  std::string body(1, static_cast<char>(key.size()));
  body.append(key).append(value);
  write_message(type, bytes_of(body), {});
}

void UlogFile::write(const UlogParam& param) {
  if (param.is_integer) {
    write_pair('P', key_of("int32_t", param.name),
               text_of_number(static_cast<std::int32_t>(param.value)));
  } else {
    write_pair('P', key_of("float", param.name), text_of_number(static_cast<float>(param.value)));
  }
}

void UlogFile::write_text(base::SimTime time, int severity, std::string_view text) {
  std::string head(1, static_cast<char>('0' + severity));
  head.append(text_of_number(base::to_time_usec(time)));
  write_message('L', bytes_of(head), bytes_of(text));
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
  if (file_) base::close_result(std::move(file_), place_);
}

}  // namespace cas::sim
