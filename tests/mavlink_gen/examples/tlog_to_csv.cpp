// SPDX-License-Identifier: BSD-3-Clause
// Prints the messages of one kind in a telemetry log on standard input as CSV:
//
//   mavlink_tlog_to_csv ATTITUDE < flight.tlog
//   time_s,system,component,time_boot_ms,roll,pitch,yaw,rollspeed,pitchspeed,yawspeed
//   1764000000.25,1,1,5000,0.1,-0.2,1.5,0,0,0
#include <array>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/services/tlog.hpp"

namespace {

using namespace cas::mav;

template <class T>
void print(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    std::cout << +static_cast<std::underlying_type_t<T>>(value);
  } else {
    if constexpr (std::is_floating_point_v<T>) {
      std::cout.precision(std::numeric_limits<T>::max_digits10);
    }
    std::cout << +value;
  }
}

template <class T, std::size_t n>
void print(const std::array<T, n>& values) {
  if constexpr (std::is_same_v<T, char>) {
    std::cout << '"';
    for (const char c : text(values)) std::cout << (c == '"' ? "\"\"" : std::string(1, c));
    std::cout << '"';
  } else {
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) std::cout << ' ';
      print(values[i]);
    }
  }
}

/// Takes every message of the dialect and prints those of the wanted name.
struct Rows {
  std::string_view name;
  double time_s{};
  Source from{};
  bool begun{};

  template <class Message>
  void operator()(const Message& message) {
    if (Message::kName != name) return;
    if (!begun) {
      std::cout << "time_s,system,component";
      for (const auto& field : Message::template kFields<>) std::cout << ',' << field.name;
      std::cout << '\n';
    }
    begun = true;
    std::cout.precision(16);  // microseconds
    std::cout << time_s << ',' << +from.system << ',' << +from.component;
    Message::for_each_field(
        [](const FieldInfo&, const auto& value) {
          std::cout << ',';
          print(value);
        },
        message);
    std::cout << '\n';
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || mavlink::common::table().find(argv[1]) == nullptr) {
    std::cerr << "usage: mavlink_tlog_to_csv MESSAGE < LOG, a message of common.xml\n";
    return 2;
  }
  const std::vector<char> log(std::istreambuf_iterator<char>(std::cin), {});
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(log.data()), log.size());
  services::TlogSplitter splitter;
  splitter.feed(bytes);
  Rows rows{.name = argv[1]};
  services::for_each_tlog_packet([&] { return splitter.next(true); }, mavlink::common::table(),
                                 [&rows](std::uint64_t unix_us, const PacketView& packet) {
                                   rows.time_s = static_cast<double>(unix_us) * 1e-6;
                                   rows.from = packet.source;
                                   mavlink::common::dispatch(packet, rows);
                                 });
}
