// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cas::test {

/// A ULog that is written message by message, so that a test can break each rule by itself.
class UlogBytes {
 public:
  explicit UlogBytes(std::uint64_t start_us = 1'000'000) : bytes_("ULog\x01\x12\x35\x01") {
    bytes_ += number(start_us);
  }

  /// The bytes of a number, as the log has it.
  template <class T>
  static std::string number(T value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }

  UlogBytes& message(char type, std::string_view body) {
    bytes_ += number(static_cast<std::uint16_t>(body.size()));
    bytes_ += type;
    bytes_ += body;
    return *this;
  }
  /// @param format  "topic:uint64_t timestamp;float x;"
  UlogBytes& format(std::string_view format) { return message('F', format); }
  UlogBytes& subscribe(std::uint16_t id, std::string_view topic, std::uint8_t instance = 0) {
    return message('A', number(instance) + number(id) + std::string(topic));
  }
  UlogBytes& data(std::uint16_t id, std::uint64_t time_us, std::string_view fields) {
    return message('D', number(id) + number(time_us) + std::string(fields));
  }
  /// A fact or a parameter. @param type  I or P
  UlogBytes& pair(char type, std::string_view key, std::string_view value) {
    return message(type, number(static_cast<std::uint8_t>(key.size())).append(key).append(value));
  }
  UlogBytes& sentence(char severity, std::uint64_t time_us, std::string_view text) {
    return message('L', number(severity) + number(time_us) + std::string(text));
  }
  UlogBytes& dropout(std::uint16_t duration_ms) { return message('O', number(duration_ms)); }
  UlogBytes& sync() { return message('S', "\x2F\x73\x13\x20\x25\x0C\xBB\x12"); }
  /// Bytes that are no message.
  UlogBytes& raw(std::string_view bytes) {
    bytes_ += bytes;
    return *this;
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace cas::test
