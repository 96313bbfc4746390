// SPDX-License-Identifier: BSD-3-Clause
// Any payload as any message: decoding, views and printing stay within it, and a packed message
// unpacks to itself. The first two bytes choose the message.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mavlink/common/all.hpp"
#include "mavlink/common/enum_text.hpp"
#include "mavlink_gen/runtime/compare.hpp"
#include "mavlink_gen/runtime/print.hpp"

namespace {

using namespace cas::mav;

template <class Message>
void check(const Message& message) {
  std::array<std::uint8_t, Message::kMaxLength> first, second;
  message.pack(first.data());
  const auto again = Message::unpack(first.data());
  again.pack(second.data());
  if (first != second) std::abort();
  std::size_t characters = 0;
  const auto count = [&](std::string_view piece) { characters += piece.size(); };
  write_json(message, count);
  write_text(message, count);
  if (characters == 0) std::abort();
  PacketBuffer buffer;
  buffer.size = encode(message, {1, 1}, 0, buffer.bytes);
  const auto decoded = decode<Message>(view_packet(buffer.view()));
  if (!decoded || for_each_difference(*decoded, again, [](const auto&...) {}) != 0) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kChoice = 2;
  if (size < kChoice) return 0;
  const auto all = mavlink::common::table().all();
  const auto& info = all[(data[0] + data[1] * 256U) % all.size()];
  PacketView packet;
  packet.version = 2;
  packet.message_id = info.id;
  packet.payload = std::span(data, size).subspan(kChoice);
  if (packet.payload.size() > kMaxPayloadBytes) packet.payload = packet.payload.first(255);
  mavlink::common::dispatch(packet, [](const auto& message) { check(message); });
  if (const auto text = view_as<mavlink::common::Statustext>(packet)) {
    if (text->text().size() > 50) std::abort();
  }
  return 0;
}
