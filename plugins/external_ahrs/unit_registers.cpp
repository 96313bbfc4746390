// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/external_ahrs/unit_registers.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>

namespace cas::sim {
namespace {

constexpr std::size_t kLongestLine = 160;
constexpr std::size_t kMostAsked = 32;
constexpr int kFirstOutput = 75;

// The unit's error codes.
constexpr const char* kBadChecksum = "03";
constexpr const char* kUnknownCommand = "04";
constexpr const char* kBadParameter = "07";
constexpr const char* kUnknownRegister = "08";

unsigned checksum(std::string_view body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return sum;
}

std::string framed(const std::string& body) {
  return fmt::format("${}*{:02X}\r\n", body, checksum(body));
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> words;
  for (;;) {
    const std::size_t comma = text.find(',');
    words.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return words;
    text.remove_prefix(comma + 1);
  }
}

int register_number(std::string_view word) {
  int number = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && end == word.data() + word.size() ? number : -1;
}

bool is_printable(char c) { return c >= ' ' && c <= '~'; }

}  // namespace

void UnitRegisters::feed(std::span<const std::uint8_t> bytes, std::string& replies) {
  for (const std::uint8_t byte : bytes) on_byte(static_cast<char>(byte), replies);
}

void UnitRegisters::on_byte(char byte, std::string& replies) {
  if (byte == '$') {
    drop_line();
    in_line_ = true;
  } else if (byte == '\r' || byte == '\n') {
    if (in_line_) on_line(replies);
    in_line_ = false;
    line_.clear();
  } else if (!in_line_) {
    ++counts_.garbage_bytes;
  } else if (!is_printable(byte) || line_.size() == kLongestLine) {
    drop_line();
    ++counts_.garbage_bytes;
  } else {
    line_ += byte;
  }
}

/// A line that did not end.
void UnitRegisters::drop_line() {
  if (in_line_) counts_.garbage_bytes += line_.size() + 1;
  in_line_ = false;
  line_.clear();
}

void UnitRegisters::on_line(std::string& replies) {
  const std::size_t star = line_.rfind('*');
  const std::string_view body = std::string_view(line_).substr(0, star);
  unsigned said = 0;
  const char* const end = line_.data() + line_.size();
  const char* const begin = star == std::string::npos ? end : line_.data() + star + 1;
  const auto [stop, problem] = std::from_chars(begin, end, said, 16);
  if (problem != std::errc() || stop != end || end - begin != 2 || said != checksum(body)) {
    ++counts_.bad_checksums;
    replies += framed(std::string("VNERR,") + kBadChecksum);
    return;
  }
  ++counts_.lines;
  note(body);
  replies += framed(answer(body));
}

std::string UnitRegisters::answer(std::string_view body) {
  const std::vector<std::string_view> words = split(body);
  if (words[0] == "VNASY" && words.size() == 2 && (words[1] == "0" || words[1] == "1")) {
    paused_ = words[1] == "0";
    ++revision_;
    return std::string(body);
  }
  if (words[0] == "VNWRG" && words.size() > 1) return write_register(body, words);
  if (words[0] != "VNRRG" || words.size() != 2) {
    return error(kUnknownCommand, std::string(words[0]) + " is not simulated");
  }
  if (register_number(words[1]) == 1) return std::string(body) + "," + model_;
  return error(kUnknownRegister, "register " + std::string(words[1]) + " is not simulated");
}

std::string UnitRegisters::write_register(std::string_view body,
                                          std::span<const std::string_view> words) {
  constexpr int kAsciiMessages = 6;
  const int number = register_number(words[1]);
  if (number == kAsciiMessages) return std::string(body);
  const auto index = static_cast<std::size_t>(number - kFirstOutput);
  if (number < kFirstOutput || index >= kOutputs) {
    return error(kUnknownRegister, "register " + std::string(words[1]) + " is not simulated");
  }
  std::string problem;
  if (!outputs_[index].write(words.subspan(2), problem)) {
    return error(kBadParameter, "register " + std::string(words[1]) + ": " + problem);
  }
  ++revision_;
  return std::string(body);
}

std::string UnitRegisters::error(const char* code, std::string why) {
  ++counts_.refused;
  refusal_ = std::move(why);
  return std::string("VNERR,") + code;
}

void UnitRegisters::note(std::string_view body) {
  const bool is_new = std::ranges::find(asked_, body) == asked_.end();
  if (is_new && asked_.size() < kMostAsked) asked_.emplace_back(body);
}

bool UnitRegisters::running() const {
  return !paused_ && std::ranges::any_of(outputs_, [](const auto& output) { return output.on(); });
}

}  // namespace cas::sim
