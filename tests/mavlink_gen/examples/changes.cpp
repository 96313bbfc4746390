// SPDX-License-Identifier: BSD-3-Clause
// Prints which fields of HEARTBEAT change in a MAVLink stream on standard input:
//
//   nc -lu 14550 | mavlink_changes
//   custom_mode: 3 -> 4
//   system_status: MAV_STATE_STANDBY -> MAV_STATE_ACTIVE
#include <unistd.h>

#include <array>
#include <cstdint>
#include <iostream>
#include <optional>
#include <span>
#include <type_traits>

#include "mavlink/common/enum_text.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/compare.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace {

using namespace cas::mav;
using mavlink::common::Heartbeat;

/// The name of an enum value where it has one, else the number.
template <class T>
void print(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    if (name_of(value).empty()) return print(static_cast<std::underlying_type_t<T>>(value));
    std::cout << name_of(value);
  } else {
    std::cout << +value;
  }
}

void print_changes(const Heartbeat& before, const Heartbeat& after) {
  for_each_difference(before, after, [](const FieldInfo& field, const auto& old, const auto& now) {
    std::cout << field.name << ": ";
    print(old);
    std::cout << " -> ";
    print(now);
    std::cout << '\n';
  });
}

}  // namespace

int main() {
  PacketParser parser(mavlink::common::table());
  std::optional<Heartbeat> last;
  std::array<std::uint8_t, 4096> bytes{};
  // read() returns the waiting bytes; fread() would wait until the buffer is full.
  for (ssize_t size; (size = ::read(STDIN_FILENO, bytes.data(), bytes.size())) > 0;) {
    parser.feed(std::span(bytes).first(static_cast<std::size_t>(size)),
                [&last](const PacketView& packet) {
                  const auto heartbeat = decode<Heartbeat>(packet);
                  if (!heartbeat) return;
                  if (last) print_changes(*last, *heartbeat);
                  last = heartbeat;
                });
  }
}
