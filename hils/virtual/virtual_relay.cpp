// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_relay.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "casd/link/direct_tx_port.hpp"
#include "casd/link/link_core.hpp"
#include "casd/station_options.hpp"

namespace cas::hils {

namespace {

constexpr base::Duration kSecond = std::chrono::seconds(1);
/// A thread that waits for room on a line looks this often.
constexpr base::Duration kTurnOfRelay = std::chrono::milliseconds(1);

/// Input buffer of a terminal, and of a UDP socket with the usual rmem_max: more is lost.
constexpr std::size_t kTtyBytes = 16'384;
constexpr std::size_t kSocketBytes = 212'992;

/// A link of the bench, as casd's ports see it. An unconnected link takes everything.
class BenchWriter final : public casd::PacketWriter {
 public:
  BenchWriter(const VirtualRelay::Write& write, const base::RunTime& now)
      : write_(write), now_(now) {}

  casd::WriteResult write(std::span<const casd::PacketRef> packets) override {
    casd::WriteResult result;
    for (const casd::PacketRef& packet : packets) {
      result.part_of_next = take(packet.bytes);
      if (result.part_of_next < packet.bytes.size()) break;
      result.part_of_next = 0;
      ++result.packets;
    }
    return result;
  }
  casd::WriteResult write_rest(std::span<const std::uint8_t> bytes) override {
    return {.part_of_next = take(bytes)};
  }
  int descriptor() const override { return -1; }

 private:
  std::size_t take(std::span<const std::uint8_t> bytes) {
    return write_ ? write_(bytes, now_) : bytes.size();
  }

  const VirtualRelay::Write& write_;
  const base::RunTime& now_;
};

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

VirtualRelay::Port::Port(const casd::LinkConfig& config, casd::LinkId id,
                         casd::Switchboard& switchboard)
    : is_line(config.type == casd::LinkType::kSerial),
      inbox_bytes(is_line ? kTtyBytes : kSocketBytes),
      counters(std::make_shared<casd::LinkCounters>(config.name, config.type)),
      ingress(std::make_unique<casd::Ingress>(id, switchboard, counters, config.accept)),
      parser(casd::make_parser()) {
  counters->ledger = std::make_unique<casd::LinkLedger>();
}

VirtualRelay::VirtualRelay(const casd::Topology& topology, WakeUp wake_up)
    : blocking_(topology.threads == casd::ThreadModel::kBlocking),
      single_(topology.threads == casd::ThreadModel::kSingle ||
              topology.threads == casd::ThreadModel::kAuto),
      wake_up_(wake_up),
      slots_(casd::slots_in_order(topology)),
      switchboard_(casd::make_plan(topology, slots_)),
      local_(std::make_shared<casd::LocalEndpoint>(switchboard_, topology.self)),
      commander_(casd::commander_options(topology),
                 [this](std::span<const std::uint8_t> packet, std::span<const casd::Path> to) {
                   send_own(packet, to);
                 }),
      threads_(topology.links.size()) {
  if (topology.links.size() > casd::kLocalLink) {  // slots are places in ports_
    throw base::ConfigError("a run on a virtual clock has 63 links at most");
  }
  ports_.reserve(topology.links.size());
  casd::LineWait& wait = *this;
  auto table = std::make_shared<casd::PortTable>();
  for (const casd::LinkConfig& link : topology.links) {
    const auto id = static_cast<casd::LinkId>(ports_.size());
    Port& port = ports_.emplace_back(link, id, switchboard_);
    const casd::TxPortOptions options = casd::tx_port_options(link);
    const auto wake = [] {};  // run() looks at each port
    if (blocking_) {
      port.tx = std::make_shared<casd::BlockingTxPort>(
          options, casd::LineDrain(topology.drain_tick), wait, port.counters, wake);
    } else {
      port.tx = std::make_shared<casd::DirectTxPort>(options, port.counters, wake);
    }
    (*table)[id] = port.tx;
  }
  (*table)[casd::kLocalLink] = local_;
  local_->wake_for_all(false);  // no thread waits for it
  switchboard_.set_ports(std::move(table));
  restart();
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
  const std::size_t used = port.inbox.size() + port.datagram_bytes;
  const std::size_t room = port.inbox_bytes - std::min(port.inbox_bytes, used);
  if (port.is_line) {
    const auto taken = bytes.first(std::min(bytes.size(), room));
    port.inbox.insert(port.inbox.end(), taken.begin(), taken.end());
  } else {
    if (room < bytes.size()) return;  // a datagram is lost as a whole
    port.datagrams.emplace_back(bytes.begin(), bytes.end());
    port.datagram_bytes += bytes.size();
  }
  serve(now);
}

void VirtualRelay::run(base::RunTime now) {
  now_ = now;
  if (!running_) {
    next_tick_ = next_second_ = now + casd::kStationTick;
    return;
  }
  if (now >= next_tick_) {
    commander_.tick(now);
    next_tick_ = now + casd::kStationTick;
  }
  if (now >= next_second_) {
    for (Port& port : ports_) port.ingress->tick(now);
    local_->tick(now);
    next_second_ = now + kSecond;
  }
  if (blocking_) return serve(now);
  handle_arrivals(now);
  carry_on(now);
}

base::RunTime VirtualRelay::next_event() const {
  base::RunTime next = std::min(next_tick_, next_second_);
  if (!running_) return next;
  if (blocking_) return std::min(next, next_turn());
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
    port.tx->detach(now_);
    port.inbox.clear();
    port.datagrams.clear();
    port.datagram_bytes = 0;
    port.parser.reset();
    port.waited = false;
    port.carry_on_at.reset();
  }
  for (std::deque<Arrival>& thread : threads_) thread.clear();
  give_up_at_.reset();
  busy_until_ = {};
}

void VirtualRelay::restart() {
  running_ = true;
  for (Port& port : ports_) port.tx->attach(std::make_unique<BenchWriter>(port.write, now_), now_);
}

void VirtualRelay::handle_arrivals(base::RunTime now) {
  for (std::deque<Arrival>& thread : threads_) {
    for (; !thread.empty() && thread.front().handled_at <= now; thread.pop_front()) {
      take(thread.front().from, thread.front().bytes, now);
    }
  }
}

/// The threads of the destinations, where packets wait for the pacer. Ports that wait for room are
/// served whenever run() is called: the link's owner calls it when there is room again.
void VirtualRelay::carry_on(base::RunTime now) {
  for (Port& port : ports_) {
    if (!port.tx->wants_room() && !(port.carry_on_at && now >= *port.carry_on_at)) continue;
    port.carry_on_at.reset();
    port.tx->carry_on(now);
    wait_for_pacer(port);
  }
}

void VirtualRelay::wait_for_pacers() {
  for (Port& port : ports_) wait_for_pacer(port);
}

void VirtualRelay::wait_for_pacer(Port& port) {
  if (blocking_ || port.carry_on_at || port.tx->due() == casd::PollSet::kNever) return;
  port.carry_on_at = port.tx->due() + wake_up_.draw();
}

// Packets.

void VirtualRelay::take(casd::LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now) {
  Port& port = ports_[from];
  casd::Ingress& ingress = *port.ingress;
  bool taken = false;
  const auto take_packet = [&](const mav::PacketView& packet) {
    taken = true;
    if (on_packet_) on_packet_(from, packet, now);
    ingress.take_packet(packet, now);
  };
  if (port.is_line) {
    ingress.parse_stream(port.parser, bytes, take_packet);
  } else {
    ingress.parse_datagram(port.parser, bytes, take_packet);
  }
  if (!taken) return;
  ingress.deliver(now);
  wait_for_pacers();
  hear(now);
}

void VirtualRelay::send_own(std::span<const std::uint8_t> packet, std::span<const casd::Path> to) {
  if (silent_) return;
  local_->send(packet, to, now_);
  wait_for_pacers();
}

/// Hands waiting packets to the commander. Packets that its answers cause follow in the next round.
void VirtualRelay::hear(base::RunTime now) {
  hear_again_ = true;
  if (hearing_) return;
  hearing_ = true;
  while (std::exchange(hear_again_, false)) local_->dispatch(commander_, now);
  hearing_ = false;
}

// Threads: blocking.

void VirtualRelay::until(base::RunTime when) {
  now_ = busy_until_ = std::max(now_, when) + wake_up_.draw();
}

void VirtualRelay::for_room(int, base::Duration at_most) {
  now_ = busy_until_ = now_ + std::min(at_most, kTurnOfRelay);
}

/// The one thread's loop, as far as it gets by `now`.
void VirtualRelay::serve(base::RunTime now) {
  while (now >= busy_until_ && anything_to_do()) {
    switch (phase_) {
      case Phase::kTakeDatagrams:
        take_datagrams(now);
        phase_ = Phase::kReadLines;
        break;
      case Phase::kReadLines:
        if (!read_lines(now)) {
          now_ = now;
          return;
        }
        phase_ = Phase::kWriteLines;
        break;
      case Phase::kWriteLines:
        write_lines();
        phase_ = Phase::kTakeDatagrams;
        break;
    }
  }
  now_ = now;
}

bool VirtualRelay::anything_to_do() const {
  return give_up_at_ || std::ranges::any_of(ports_, [this](const Port& port) {
           return !port.is_empty() || port.tx->due() <= now_;
         });
}

base::RunTime VirtualRelay::next_turn() const {
  if (give_up_at_ && busy_until_ <= now_) return *give_up_at_;
  if (anything_to_do()) return busy_until_;
  base::RunTime next = casd::PollSet::kNever;
  for (const Port& port : ports_) next = std::min(next, port.tx->due());
  return std::max(next, busy_until_);
}

void VirtualRelay::take_datagrams(base::RunTime now) {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    const std::deque<std::vector<std::uint8_t>> datagrams = std::exchange(ports_[i].datagrams, {});
    ports_[i].datagram_bytes = 0;
    for (const auto& bytes : datagrams) take(static_cast<casd::LinkId>(i), bytes, now);
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
        if (!give_up_at_) give_up_at_ = now + casd::kBlockingPatience;
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

void VirtualRelay::write_lines() {
  for (Port& port : ports_) {
    if (port.tx->due() <= now_) port.tx->carry_on(now_);
  }
}

}  // namespace cas::hils
