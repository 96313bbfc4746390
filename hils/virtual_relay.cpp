// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual_relay.hpp"

#include <algorithm>
#include <chrono>

#include "base/error.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::hils {

namespace {

constexpr base::Duration kTickPeriod = std::chrono::milliseconds(50);
constexpr base::Duration kSecond = std::chrono::seconds(1);

casd::LinePacer pacer_for(const casd::LinkConfig& link) {
  if (link.max_bytes_s > 0) return casd::LinePacer(link.max_bytes_s);
  if (link.type == casd::LinkType::kSerial && link.pace && link.baud > 0) {
    return casd::LinePacer::for_baud(link.baud);
  }
  return {};
}

casd::CommanderOptions commander_options(const casd::Topology& topology) {
  casd::CommanderOptions options;
  options.self = topology.self;
  options.heartbeat_hz = topology.commanding.heartbeat_hz;
  options.allow_not_hil = topology.commanding.allow_not_hil;
  return options;
}

}  // namespace

VirtualRelay::Port::Port(const casd::LinkConfig& config)
    : queue(config.queue), pacer(pacer_for(config)), parser(mav::public_table()) {}

VirtualRelay::VirtualRelay(const casd::Topology& topology)
    : slots_(casd::slots_in_order(topology)),
      router_(casd::make_plan(topology, slots_), mav::public_table(), topology.route_lifetime),
      commander_(commander_options(topology),
                 [this](std::span<const std::uint8_t> bytes) { send_own(bytes); }),
      own_parser_(mav::public_table()) {
  ports_.reserve(topology.links.size());
  for (const casd::LinkConfig& link : topology.links) ports_.emplace_back(link);
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    ports_[i].queue = casd::TxQueue(topology.links[i].queue,
                                    [this, i](const casd::PacketInfo&, casd::DropCause cause) {
                                      ++ports_[i].dropped[static_cast<std::size_t>(cause)];
                                    });
  }
}

casd::LinkId VirtualRelay::link(const std::string& name) const {
  const auto found = slots_.find(name);
  if (found == slots_.end()) throw base::ConfigError("the topology has no link '" + name + "'");
  return found->second;
}

void VirtualRelay::connect(casd::LinkId link, Write write) {
  ports_.at(link).write = std::move(write);
}

void VirtualRelay::receive(casd::LinkId from, std::span<const std::uint8_t> bytes,
                           base::RunTime now) {
  now_ = now;
  ports_[from].parser.feed(bytes, [&](const mav::PacketView& packet) {
    if (on_packet_) on_packet_(from, packet, now);
    route(from, packet, now);
  });
}

void VirtualRelay::route(casd::LinkId from, const mav::PacketView& packet, base::RunTime now) {
  const casd::Route route = router_.on_packet(from, packet, now);
  if (route.verdict != casd::Route::Verdict::kForward) return;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if ((route.to & casd::bit(static_cast<casd::LinkId>(i))) == 0) continue;
    ports_[i].queue.push(route.info, packet.bytes);
    pump(ports_[i], now);
  }
  if ((route.to & casd::bit(casd::kLocalLink)) != 0) commander_.on_packet(from, packet, now);
}

void VirtualRelay::send_own(std::span<const std::uint8_t> bytes) {
  own_parser_.feed(
      bytes, [this](const mav::PacketView& packet) { route(casd::kLocalLink, packet, now_); });
}

void VirtualRelay::run(base::RunTime now) {
  now_ = now;
  for (Port& port : ports_) pump(port, now);
  if (now >= next_tick_) {
    commander_.tick(now);
    next_tick_ = now + kTickPeriod;
  }
  if (now >= next_second_) {
    for (const auto& [name, link] : slots_) router_.tick(link, now);
    next_second_ = now + kSecond;
  }
}

base::RunTime VirtualRelay::next_event() const {
  base::RunTime next = std::min(next_tick_, next_second_);
  for (const Port& port : ports_) {
    // A tail waits for the link, whose owner calls run() when it has room again.
    if (!port.queue.empty() && port.tail.empty()) next = std::min(next, port.pacer.ready_at());
  }
  return next;
}

void VirtualRelay::pump(Port& port, base::RunTime now) {
  while (write_tail(port, now) && port.pacer.ready(now)) {
    const std::optional<casd::QueuedPacket> packet = port.queue.pop(now, port.pacer);
    if (!packet) return;
    port.pacer.sent(packet->bytes.size(), now);
    port.tail.assign(packet->bytes.begin(), packet->bytes.end());
  }
}

/// @return true when nothing of a packet is left to be written
bool VirtualRelay::write_tail(Port& port, base::RunTime now) {
  if (port.tail.empty()) return true;
  const std::size_t taken = port.write ? port.write(port.tail, now) : port.tail.size();
  port.tail.erase(port.tail.begin(), port.tail.begin() + static_cast<std::ptrdiff_t>(taken));
  return port.tail.empty();
}

}  // namespace cas::hils
