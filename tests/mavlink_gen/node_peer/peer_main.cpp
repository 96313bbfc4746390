// SPDX-License-Identifier: BSD-3-Clause
// Our end of the test against node-mavlink. `send` prints packets of every message with their
// values; `receive` reads packets in hex and prints their contents.
#include <array>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/signing.hpp"

namespace {

using namespace cas::mav;
using nlohmann::json;
namespace common = mavlink::common;

constexpr int kPacketsOfEach = 20;
constexpr Source kSource{42, 7};
constexpr std::uint8_t kLink = 3;
constexpr std::uint64_t kStart = 1'700'000'000'000'000;  // us, Unix time of the first signature

std::string hex_of(std::span<const std::uint8_t> bytes) {
  std::string out;
  for (const auto byte : bytes) {
    out += "0123456789abcdef"[byte >> 4U];
    out += "0123456789abcdef"[byte & 15U];
  }
  return out;
}

std::vector<std::uint8_t> bytes_of(const std::string& hex) {
  std::vector<std::uint8_t> out;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    out.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return out;
}

/// Numbers; those of 64 bit as text, JavaScript has no room for them.
template <class T>
json json_of(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return json_of(static_cast<std::underlying_type_t<T>>(value));
  } else if constexpr (std::is_integral_v<T> && sizeof(T) == 8) {
    return std::to_string(value);
  } else {
    return value;
  }
}

template <class T, std::size_t n>
json json_of(const std::array<T, n>& values) {
  if constexpr (std::is_same_v<T, char>) {
    return text(values);
  } else {
    json out = json::array();
    for (const auto& value : values) out.push_back(json_of(value));
    return out;
  }
}

template <class T>
void randomise(T& value, std::mt19937_64& random) {
  if constexpr (std::is_floating_point_v<T>) {
    constexpr double kStep = 0.25;  // exact in binary
    value = static_cast<T>(static_cast<double>(random() % 4000) * kStep - 500);
  } else {
    value = static_cast<T>(random());
    // A payload of zeros alone has one byte here, as MAVLink 2 wants it, and none in node-mavlink.
    if (value == T{}) value = static_cast<T>(1);
  }
}

template <class T, std::size_t n>
void randomise(std::array<T, n>& values, std::mt19937_64& random) {
  if constexpr (std::is_same_v<T, char>) {
    std::string word(1 + random() % n, 'a');
    for (auto& c : word) c = static_cast<char>('a' + random() % 26);
    set_text(values, word);
  } else {
    for (auto& value : values) randomise(value, random);
  }
}

template <class Message>
json fields_of(const Message& message) {
  json out = json::object();
  Message::for_each_field([&](const FieldInfo& field,
                              const auto& value) { out[std::string(field.name)] = json_of(value); },
                          message);
  return out;
}

class Peer final {
 public:
  explicit Peer(bool with_signatures)
      : with_signatures_(with_signatures), signing_(signing_key("peer"), signing_time(kStart)) {}

  void send() {
    for (const auto& info : common::table().all()) {
      PacketView packet;
      packet.message_id = info.id;
      common::dispatch(packet, [&]<class Message>(const Message&) {
        for (int i = 0; i < kPacketsOfEach; ++i) send_random<Message>();
      });
    }
  }

  void receive() {
    PacketParser parser(common::table());
    for (std::string line; std::getline(std::cin, line);) {
      parser.feed(bytes_of(line), [&](const PacketView& packet) {
        const auto accepted_here =
            !with_signatures_ || signing_.verify(packet) == SignatureVerdict::kAccepted;
        common::dispatch(packet, [&](const auto& message) {
          std::cout << json{{"id", packet.message_id},
                            {"accepted", accepted_here},
                            {"fields", fields_of(message)}}
                    << '\n';
        });
      });
    }
  }

 private:
  template <class Message>
  void send_random() {
    Message message;
    // Some packets end in zeros, for the truncation.
    std::size_t kept = random_() % 2 == 0 ? 1 + random_() % std::size(Message::template kFields<>)
                                          : std::size(Message::template kFields<>);
    Message::for_each_field(
        [&](const FieldInfo& field, auto& value) {
          if (field.name == "mavlink_version" || kept == 0) return;
          --kept;
          randomise(value, random_);
        },
        message);
    PacketBuffer buffer;
    buffer.size = with_signatures_
                      ? signing_.encode(message, kSource, sequence_, kLink, buffer.bytes)
                      : encode(message, kSource, sequence_, buffer.bytes);
    std::cout << json{{"id", Message::kId},
                      {"sequence", sequence_++},
                      {"hex", hex_of(buffer.view())},
                      {"fields", fields_of(message)}}
              << '\n';
  }

  bool with_signatures_;
  Signing<> signing_;
  std::uint8_t sequence_{};
  std::mt19937_64 random_{17};
};

}  // namespace

int main(int argc, char** argv) {
  const std::string command = argc > 1 ? argv[1] : "";
  Peer peer(argc > 2 && std::string(argv[2]) == "--signed");
  if (command == "send") {
    peer.send();
  } else if (command == "receive") {
    peer.receive();
  } else {
    std::cerr << "usage: mavlink_peer send|receive [--signed]\n";
    return 2;
  }
  return 0;
}
