// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_relay.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::hils {

namespace {

constexpr base::Duration kTickPeriod = std::chrono::milliseconds(50);
constexpr base::Duration kSecond = std::chrono::seconds(1);
/// As casd: silence after which the rest of a packet is given up (threads: blocking).
constexpr base::Duration kBlockingPatience = std::chrono::milliseconds(20);

/// Input buffer of a terminal, and of a UDP socket with the usual rmem_max: more is lost.
constexpr std::size_t kTtyBytes = 16'384;
constexpr std::size_t kSocketBytes = 212'992;

casd::LinePacer pacer_for(const casd::LinkConfig& link, casd::ThreadModel threads) {
  const base::Duration slack =
      threads == casd::ThreadModel::kBlocking ? base::Duration{} : casd::LinePacer::kSlack;
  if (link.max_bytes_s > 0) return casd::LinePacer(link.max_bytes_s, slack);
  if (link.type == casd::LinkType::kSerial && link.pace && link.baud > 0) {
    return casd::LinePacer::for_baud(link.baud, slack);
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

WakeUp::WakeUp(const WakeUpFigures& figures, std::uint64_t seed)
    : median_us_(figures.p50_us), random_(seed) {
  constexpr double kNormal99 = 2.326348;  // 99th percentile of the standard normal distribution
  if (median_us_ <= 0) return;
  sigma_ = std::log(std::max(figures.p99_us, median_us_) / median_us_) / kNormal99;
}

base::Duration WakeUp::draw() {
  if (is_instant()) return {};
  return base::from_seconds(1e-6 * median_us_ * std::exp(sigma_ * random_()));
}

VirtualRelay::Port::Port(const casd::LinkConfig& config)
    : is_line(config.type == casd::LinkType::kSerial),
      inbox_bytes(is_line ? kTtyBytes : kSocketBytes),
      queue(config.queue),
      parser(mav::public_table()) {}

VirtualRelay::VirtualRelay(const casd::Topology& topology, WakeUp wake_up)
    : blocking_(topology.threads == casd::ThreadModel::kBlocking),
      single_(topology.threads == casd::ThreadModel::kSingle),
      drain_(topology.drain_tick),
      wake_up_(wake_up),
      slots_(casd::slots_in_order(topology)),
      router_(casd::make_plan(topology, slots_), mav::public_table(), topology.route_lifetime),
      commander_(commander_options(topology),
                 [this](std::span<const std::uint8_t> bytes, std::span<const casd::Path> to) {
                   send_own(bytes, to);
                 }),
      own_parser_(mav::public_table()),
      threads_(topology.links.size()) {
  ports_.reserve(topology.links.size());
  for (const casd::LinkConfig& link : topology.links) {
    const std::size_t i = ports_.size();
    Port& port = ports_.emplace_back(link);
    port.pacer = pacer_for(link, topology.threads);
    if (!blocking_) port.pacer.set_sensor_gap(link.sensor_gap);
    port.queue =
        casd::TxQueue(link.queue, [this, i](const casd::PacketInfo& info, casd::DropCause cause) {
          ports_[i].ledger.dropped(info, cause, now_);
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
  if (!running_) return;
  if (!blocking_) {
    if (wake_up_.is_instant()) return take(from, bytes, now);
    std::deque<Arrival>& thread = thread_of(from);
    const base::RunTime at = thread.empty() ? now + wake_up_.draw() : thread.back().handled_at;
    thread.push_back({at, from, {bytes.begin(), bytes.end()}});
    return;
  }
  const bool asleep = now >= busy_until_ && (!anything_to_do() || give_up_at_);
  if (asleep) busy_until_ = now + wake_up_.draw();
  Port& port = ports_[from];
  const std::size_t room = port.inbox_bytes - std::min(port.inbox_bytes, port.inbox.size());
  if (!port.is_line && room < bytes.size()) return;  // a datagram is lost as a whole
  const auto taken = bytes.first(std::min(bytes.size(), room));
  port.inbox.insert(port.inbox.end(), taken.begin(), taken.end());
  serve(now);
}

void VirtualRelay::run(base::RunTime now) {
  now_ = now;
  if (!running_) {
    next_tick_ = next_second_ = now + kTickPeriod;
    return;
  }
  if (now >= next_tick_) {
    commander_.tick(now);
    next_tick_ = now + kTickPeriod;
  }
  if (now >= next_second_) {
    for (const auto& [name, link] : slots_) router_.tick(link, now);
    next_second_ = now + kSecond;
  }
  if (blocking_) return serve(now);
  handle_arrivals(now);
  carry_on(now);
}

base::RunTime VirtualRelay::next_event() const {
  base::RunTime next = std::min(next_tick_, next_second_);
  if (!running_) return next;
  if (blocking_) {
    if (!anything_to_do()) return next;
    return std::min(next, give_up_at_ && busy_until_ <= now_ ? *give_up_at_ : busy_until_);
  }
  for (const std::deque<Arrival>& thread : threads_) {
    if (!thread.empty()) next = std::min(next, thread.front().handled_at);
  }
  for (const Port& port : ports_) {
    if (port.carry_on_at) next = std::min(next, *port.carry_on_at);
  }
  return next;
}

void VirtualRelay::kill() {
  running_ = false;
  for (Port& port : ports_) {
    port.queue.clear(casd::DropCause::kClosed);
    port.pacer.reset();
    port.tail.clear();
    port.inbox.clear();
    port.parser.reset();
    port.waited = false;
    port.carry_on_at.reset();
  }
  for (std::deque<Arrival>& thread : threads_) thread.clear();
  give_up_at_.reset();
  busy_until_ = {};
}

void VirtualRelay::handle_arrivals(base::RunTime now) {
  for (std::deque<Arrival>& thread : threads_) {
    for (; !thread.empty() && thread.front().handled_at <= now; thread.pop_front()) {
      take(thread.front().from, thread.front().bytes, now);
    }
  }
}

/// The threads of the destinations, where packets wait for the pacer. A tail waits for the link
/// itself, whose owner calls run() when it has room again.
void VirtualRelay::carry_on(base::RunTime now) {
  for (Port& port : ports_) {
    if (!port.tail.empty() || (port.carry_on_at && now >= *port.carry_on_at)) {
      port.carry_on_at.reset();
      pump(port, now);
    }
  }
}

// Packets.

void VirtualRelay::take(casd::LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now) {
  ports_[from].parser.feed(bytes, [&](const mav::PacketView& packet) {
    if (on_packet_) on_packet_(from, packet, now);
    route(from, packet, now);
  });
}

void VirtualRelay::route(casd::LinkId from, const mav::PacketView& packet, base::RunTime now) {
  pass_on(from, router_.on_packet(from, packet, now), packet, now);
}

void VirtualRelay::pass_on(casd::LinkId from, const casd::Route& route,
                           const mav::PacketView& packet, base::RunTime now) {
  if (from != casd::kLocalLink) ports_[from].ledger.received(route.info);
  if (route.decision != casd::Route::Decision::kForward) return;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if ((route.to & casd::bit(static_cast<casd::LinkId>(i))) == 0) continue;
    ports_[i].queue.push(route.info, packet.bytes);
    if (!blocking_ || !ports_[i].pacer.limited()) pump(ports_[i], now);
  }
  if ((route.to & casd::bit(casd::kLocalLink)) != 0) {
    commander_.on_packet(casd::Origin{{from}, route.info.from_group}, packet, now);
  }
}

void VirtualRelay::send_own(std::span<const std::uint8_t> bytes, std::span<const casd::Path> to) {
  own_parser_.feed(bytes, [&](const mav::PacketView& packet) {
    if (to.empty()) return route(casd::kLocalLink, packet, now_);
    pass_on(casd::kLocalLink, router_.on_addressed(packet, to, now_), packet, now_);
  });
}

void VirtualRelay::pump(Port& port, base::RunTime now) {
  while (write_tail(port, now) && port.pacer.ready(now)) {
    if (!write_packet(port, now)) return;
  }
  if (port.queue.empty() || !port.tail.empty() || port.carry_on_at) return;
  port.carry_on_at = port.pacer.ready_at() + wake_up_.draw();
}

/// @return false when there was none
bool VirtualRelay::write_packet(Port& port, base::RunTime now) {
  const std::optional<casd::QueuedPacket> packet = port.queue.pop(now, port.pacer);
  if (!packet) return false;
  port.pacer.sent(packet->bytes.size(), now);
  if (packet->info.message_id == mavlink::common::HilSensor::kId) port.pacer.sent_sensor(now);
  port.ledger.sent(packet->info, now);
  port.tail.assign(packet->bytes.begin(), packet->bytes.end());
  write_tail(port, now);
  return true;
}

/// @return true when nothing of a packet is left to be written
bool VirtualRelay::write_tail(Port& port, base::RunTime now) {
  if (port.tail.empty()) return true;
  const std::size_t taken = port.write ? port.write(port.tail, now) : port.tail.size();
  port.tail.erase(port.tail.begin(), port.tail.begin() + static_cast<std::ptrdiff_t>(taken));
  return port.tail.empty();
}

// Threads: blocking.

/// The one thread's loop, as far as it gets by `now`.
void VirtualRelay::serve(base::RunTime now) {
  while (now >= busy_until_ && anything_to_do()) {
    switch (phase_) {
      case Phase::kTakeDatagrams:
        take_datagrams(now);
        phase_ = Phase::kReadLines;
        break;
      case Phase::kReadLines:
        if (!read_lines(now)) return;
        phase_ = Phase::kWriteLines;
        break;
      case Phase::kWriteLines:
        write_lines(now);
        phase_ = Phase::kTakeDatagrams;
        break;
    }
  }
}

bool VirtualRelay::anything_to_do() const {
  return give_up_at_ || std::ranges::any_of(ports_, [](const Port& port) {
           return !port.inbox.empty() || !port.queue.empty() || !port.tail.empty();
         });
}

void VirtualRelay::take_datagrams(base::RunTime now) {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (ports_[i].is_line || ports_[i].inbox.empty()) continue;
    const std::vector<std::uint8_t> bytes(ports_[i].inbox.begin(), ports_[i].inbox.end());
    ports_[i].inbox.clear();
    take(static_cast<casd::LinkId>(i), bytes, now);
  }
}

/// Reads the bytes that wait on each line. @return false while the thread waits for the rest of a
/// packet
bool VirtualRelay::read_lines(base::RunTime now) {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    Port& port = ports_[i];
    if (!port.is_line || (give_up_at_ ? !port.waited : port.inbox.empty())) continue;
    if (!port.inbox.empty()) give_up_at_.reset();
    while (!port.inbox.empty() || port.parser.inside_packet()) {
      if (port.inbox.empty()) {
        if (!give_up_at_) give_up_at_ = now + kBlockingPatience;
        port.waited = true;
        if (now < *give_up_at_) return false;
        break;
      }
      const std::uint8_t byte = port.inbox.front();
      port.inbox.pop_front();
      take(static_cast<casd::LinkId>(i), {&byte, 1}, now);
      if (port.waited && !port.parser.inside_packet()) break;
    }
    port.waited = false;
    give_up_at_.reset();
  }
  return true;
}

void VirtualRelay::write_lines(base::RunTime now) {
  for (Port& port : ports_) {
    if (!write_tail(port, now) || !port.pacer.limited() || port.queue.empty()) continue;
    if (!write_packet(port, now)) continue;
    const base::Duration fifo_time = port.pacer.time_for(casd::LineDrain::kFifoBytes);
    const base::RunTime drained = drain_.done(now, port.pacer.arrival(0, now), fifo_time);
    busy_until_ = std::max(busy_until_, drained + wake_up_.draw());
  }
}

}  // namespace cas::hils
