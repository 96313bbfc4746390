// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/fleet.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::test {
namespace {

using namespace mavlink::common;  // NOLINT
using nlohmann::json;

/// They carry their number in time_boot_ms.
using Kinds =
    std::tuple<Attitude, AttitudeQuaternion, LocalPositionNed, GlobalPositionInt, SystemTime,
               ScaledImu, ScaledPressure, RcChannels, AttitudeTarget, NamedValueFloat>;
static_assert(std::tuple_size_v<Kinds> == FleetLoad::kMostKinds);

/// The packet of this number. @param kind  counted around
template <std::size_t... index>
std::span<const std::uint8_t> encode(std::size_t kind, std::uint32_t number, mav::Encoder& encoder,
                                     std::index_sequence<index...>) {
  std::span<const std::uint8_t> bytes;
  const auto one = [&]<class Message>(Message message, std::size_t own) {
    if (own != kind) return;
    message.time_boot_ms = number;
    bytes = encoder(message);
  };
  (one(std::tuple_element_t<index, Kinds>{}, index), ...);
  return bytes;
}

template <std::size_t... index>
std::optional<std::uint32_t> number_of(const mav::PacketView& packet,
                                       std::index_sequence<index...>) {
  std::optional<std::uint32_t> number;
  const auto one = [&]<class Message>(const Message&) {
    if (const auto message = mav::decode<Message>(packet)) number = message->time_boot_ms;
  };
  (one(std::tuple_element_t<index, Kinds>{}), ...);
  return number;
}

constexpr auto kAll = std::make_index_sequence<FleetLoad::kMostKinds>();

std::int64_t ns(base::RunTime time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

}  // namespace

Fleet::Fleet(const FleetLoad& load) : load_(load), sent_ns_(total()) {
  for (int i = 0; i < load.vehicles; ++i) vehicles_.push_back(std::make_unique<Vehicle>(i));
  for (int i = 0; i < load.stations; ++i) stations_.push_back(std::make_unique<Station>());
  for (const auto& station : stations_) station->delay_ns.assign(total(), -1);
}

std::string Fleet::topology(std::uint16_t command, const std::string& link_keys) const {
  std::string yaml = "schema: 1\ncommand_port: {port: " + std::to_string(command) +
                     ", loopback_without_token: true}\ncommanding: {heartbeat_hz: 0}\nlinks:\n";
  std::string vehicles;
  std::string stations;
  const auto add = [&](std::string& names, const std::string& name, const UdpPeer& end) {
    yaml += "  - {name: " + name + ", type: udp, remote: \"" + end.endpoint() + "\"" + link_keys +
            "}\n";
    names += (names.empty() ? "" : ", ") + name;
  };
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    add(vehicles, "v" + std::to_string(i), vehicles_[i]->socket);
  }
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    add(stations, "s" + std::to_string(i), stations_[i]->socket);
  }
  return yaml + "routes:\n  - {from: [" + vehicles + "], to: [" + stations + "]}\n  - {from: [" +
         stations + "], to: [" + vehicles + "]}\n";
}

bool Fleet::meet(base::rpc::Client& casd) {
  const json links = casd.call("link.list", json::object());
  for (const json& link : links) {
    if (link["state"] != "up") return false;
    const std::string name = link["name"];
    if (name[0] != 'v') continue;
    vehicles_.at(std::stoul(name.substr(1)))->socket.set_remote(port_of(link["endpoint"]));
  }
  return links.size() == vehicles_.size() + stations_.size();
}

bool Fleet::send_due(base::RunTime now) {
  if (turn_ == 0) begin_ = now;
  for (; turn_ < total() && next_due() <= now; ++turn_) {
    const std::size_t i = turn_ % vehicles_.size();
    const auto number = static_cast<std::uint32_t>(turn_ / vehicles_.size());
    sent_ns_[slot(i, number)].store(ns(now));
    const std::size_t kind = number % static_cast<std::uint32_t>(load_.kinds);
    vehicles_[i]->socket.send(encode(kind, number, vehicles_[i]->encoder, kAll));
  }
  return turn_ == total();
}

base::RunTime Fleet::next_due() const {
  const double period_s = 1 / (load_.hz * load_.vehicles);
  return begin_ + base::from_seconds(static_cast<double>(turn_) * period_s);
}

void Fleet::read(base::RunTime now) {
  for (const auto& station : stations_) {
    station->socket.read(station->stream);
    for (auto& packets = station->stream.packets(); !packets.empty(); packets.pop_front()) {
      const auto number = number_of(packets.front().view(), kAll);
      if (!number) continue;
      const std::size_t at = slot(packets.front().source.system - 1U, *number);
      if (station->delay_ns.at(at) >= 0) ++repeated_;
      station->delay_ns.at(at) = std::max<std::int64_t>(0, ns(now) - sent_ns_[at].load());
    }
  }
}

std::size_t Fleet::total() const {
  return static_cast<std::size_t>(load_.vehicles) * static_cast<std::size_t>(load_.packets());
}

std::size_t Fleet::slot(std::size_t vehicle, std::uint32_t number) const {
  return vehicle * static_cast<std::size_t>(load_.packets()) + number;
}

std::vector<std::size_t> Fleet::missing() const {
  std::vector<std::size_t> missing;
  for (const auto& station : stations_) {
    missing.push_back(static_cast<std::size_t>(std::ranges::count(station->delay_ns, -1)));
  }
  return missing;
}

double Fleet::delay_us(double q) const {
  std::vector<std::int64_t> delays;
  for (const auto& station : stations_) {
    std::ranges::copy_if(station->delay_ns, std::back_inserter(delays),
                         [](std::int64_t delay) { return delay >= 0; });
  }
  if (delays.empty()) return 0;
  std::ranges::sort(delays);
  const auto at = static_cast<std::size_t>(q * static_cast<double>(delays.size() - 1));
  return static_cast<double>(delays[at]) * 1e-3;
}

}  // namespace cas::test
