// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/ground_station.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "base/error.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/param_request_list.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/services/station_heartbeat.hpp"

namespace cas::hils {

namespace {

namespace mv = mavlink::common;

constexpr base::Duration kHeartbeatPeriod = std::chrono::seconds(1);
constexpr base::Duration kSticksPeriod = std::chrono::milliseconds(40);  ///< as QGroundControl

/// On-screen sticks at rest.
mv::ManualControl centred_sticks(std::uint8_t vehicle_system) {
  mv::ManualControl message;
  message.target = vehicle_system;
  message.z = 500;
  return message;
}

sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

}  // namespace

GroundStation::GroundStation(const std::vector<std::uint8_t>& systems, base::Duration list_period,
                             Send send)
    : list_period_(list_period),
      send_(std::move(send)),
      encode_(kGroundStation),
      parser_(mv::table()) {
  for (const std::uint8_t system : systems) vehicles_.push_back({.system = system});
}

void GroundStation::on_bytes(std::span<const std::uint8_t> bytes) {
  parser_.feed(bytes, [this](const mav::PacketView& packet) { on_packet(packet); });
}

void GroundStation::on_packet(const mav::PacketView& packet) {
  if (packet.message_id != mv::Heartbeat::kId) return;
  const auto sender = std::ranges::find(vehicles_, packet.source.system, &Vehicle::system);
  if (sender != vehicles_.end()) sender->heard = true;
}

void GroundStation::tick(base::RunTime now) {
  if (silent_) {
    last_tick_ = now;
    return;
  }
  send_flood(std::exchange(last_tick_, now), now);
  if (now >= next_heartbeat_) {
    send_(encode_(mav::services::station_heartbeat(mv::MavType::kGcs)));
    next_heartbeat_ = now + kHeartbeatPeriod;
  }
  for (Vehicle& vehicle : vehicles_) {
    if (vehicle.heard) attend(vehicle, now);
  }
}

void GroundStation::attend(Vehicle& vehicle, base::RunTime now) {
  if (now >= vehicle.next_sticks) {
    send_(encode_(centred_sticks(vehicle.system)));
    vehicle.next_sticks = now + kSticksPeriod;
  }
  if (vehicle.next_list && now < *vehicle.next_list) return;
  mv::ParamRequestList request;
  request.target_system = vehicle.system;
  request.target_component = 1;
  send_(encode_(request));
  vehicle.next_list = now + list_period_;
}

/// On a grid, so that short ticks lose nothing; after a stall no more than a moment's worth.
void GroundStation::send_flood(base::RunTime last, base::RunTime now) {
  constexpr base::Duration kMostAtOnce = std::chrono::milliseconds(100);
  const base::RunTime begin = std::max(last, now - kMostAtOnce);
  const std::int64_t end = flood_.index_at(now.time_since_epoch());
  for (std::int64_t i = flood_.index_at(begin.time_since_epoch()); i < end; ++i) {
    const auto turn = static_cast<std::size_t>(i) % vehicles_.size();
    send_(encode_(centred_sticks(vehicles_[turn].system)));
  }
}

GroundStationThread::GroundStationThread(std::vector<std::uint8_t> systems)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      systems_(std::move(systems)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  if (!socket_ || !stop_ || ::bind(socket_.get(), generic(address), size) != 0 ||
      ::getsockname(socket_.get(), generic(address), &size) != 0) {
    throw base::ConfigError("cannot open a UDP port for the ground station");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { run(); });
}

GroundStationThread::~GroundStationThread() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(stop_.get(), &one, sizeof(one));
  thread_.join();
}

void GroundStationThread::run() {
  sockaddr_in peer{};
  GroundStation station(systems_, kParameterListPeriod, [&](std::span<const std::uint8_t> bytes) {
    if (peer.sin_port == 0) return;  // no peer is known yet
    ::sendto(socket_.get(), bytes.data(), bytes.size(), 0, generic(peer), sizeof(peer));
  });
  std::array<std::uint8_t, 2048> buffer{};
  constexpr int kTickMs =
      static_cast<int>(GroundStation::kTickPeriod / std::chrono::milliseconds(1));
  while (true) {
    std::array<pollfd, 2> fds{pollfd{socket_.get(), POLLIN, 0}, pollfd{stop_.get(), POLLIN, 0}};
    ::poll(fds.data(), fds.size(), kTickMs);
    if (fds[1].revents != 0) return;
    while (true) {
      socklen_t size = sizeof(peer);
      const ssize_t received =
          ::recvfrom(socket_.get(), buffer.data(), buffer.size(), 0, generic(peer), &size);
      if (received <= 0) break;
      station.on_bytes(std::span(buffer).first(static_cast<std::size_t>(received)));
    }
    station.flood(flood_hz_);
    station.tick(base::steady_now());
  }
}

}  // namespace cas::hils
