// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/ingress.hpp"

#include <fmt/format.h>
#include <utility>

#include "base/os/log.hpp"
#include "casd/packet/intervention.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

/// Packets of the HIL loop command nothing.
bool is_sensor_or_actuator(TrafficClass traffic) {
  return traffic == TrafficClass::kHil || traffic == TrafficClass::kGps;
}

}  // namespace

Parser make_parser() { return Parser(mav::public_table()); }

Ingress::Ingress(LinkId link, Switchboard& switchboard, std::shared_ptr<LinkCounters> counters,
                 AcceptRule accept, std::shared_ptr<LinkSigning> signing)
    : link_(link),
      switchboard_(switchboard),
      counters_(std::move(counters)),
      accept_(std::move(accept)),
      accepts_all_(accept_ == AcceptRule{}),
      signing_(std::move(signing)) {}

void Ingress::take(Parser& parser, std::span<const std::uint8_t> bytes, base::RunTime now,
                   PeerId peer) {
  parse_stream(parser, bytes,
               [&](const mav::PacketView& packet) { take_packet(packet, now, peer); });
}

void Ingress::take_datagram(Parser& parser, std::span<const std::uint8_t> bytes, base::RunTime now,
                            base::Duration waited) {
  parse_datagram(parser, bytes,
                 [&](const mav::PacketView& packet) { take_packet(packet, now, {}, waited); });
}

void Ingress::take_packet(const mav::PacketView& packet, base::RunTime now, PeerId peer,
                          base::Duration waited) {
  if (!admit_packet(packet, now)) return;
  Route route = switchboard_.router().on_packet(link_, packet, now, peer);
  route.info.waited = waited;
  if (route.loop_found) log_loop();
  const bool first = route.decision != Route::Decision::kDuplicate;
  const bool may_command = first && !is_sensor_or_actuator(route.info.traffic);
  if (may_command && is_failure(packet)) {
    route.to = bit(kLocalLink);
    route.thinned = {};
    route.held = 0;
    route.decision = Route::Decision::kForward;
  }
  if (!first && is_failure(packet)) route.to = {};
  account(route, packet, now);
  // casd's station also hears commands of others and the vehicle's answers to them, whichever
  // station they are for, so that it does not undo them. A packet that was held back commanded
  // nothing.
  if (may_command && may_be_act(packet.message_id)) {
    route.to.add(kLocalLink);
    if (route.decision == Route::Decision::kNotHil) route.to = {};
  }
  if (!route.to.empty()) batch_.add(route.info, packet.bytes, route.to);
  add_for_sniffers(route, packet, now);
}

void Ingress::log_loop() const {
  base::log::warn("link " + counters_->name +
                  ": a loop: packets of other links come back here again and again, because "
                  "somebody forwards what casd sends. Such copies are dropped as duplicates "
                  "(docs/use/troubleshooting.md)");
}

void Ingress::take_addressed(const mav::PacketView& packet, std::span<const Path> to,
                             base::RunTime now) {
  if (!admit_packet(packet, now)) return;
  Route route = switchboard_.router().on_addressed(packet, to, now);
  account(route, packet, now);
  // Each path has its own peer; the other links of a group may use any that knows the target.
  for (const Path& path : to) {
    if (!route.to.has(path.link)) continue;
    if (batch_.full()) deliver(now);
    PacketInfo info = route.info;
    info.to_serial = path.peer;
    batch_.add(info, packet.bytes, bit(path.link));
    route.to.remove(path.link);
  }
  add_for_sniffers(route, packet, now);
  if (route.to.empty()) return;
  if (batch_.full()) deliver(now);
  batch_.add(route.info, packet.bytes, route.to);
}

/// All peers of a sniffer get it, whoever it is for.
void Ingress::add_for_sniffers(const Route& route, const mav::PacketView& packet,
                               base::RunTime now) {
  if (route.sniffers == nullptr) return;
  if (batch_.full()) deliver(now);
  PacketInfo info = route.info;
  info.to_all_peers = true;
  batch_.add(info, packet.bytes, *route.sniffers);
}

/// Counts the received packet. @return whether the link lets it in
bool Ingress::admit_packet(const mav::PacketView& packet, base::RunTime now) {
  if (batch_.full()) deliver(now);
  counters_->rx.packets.add();
  if (const unsigned lost = sequence_.update(packet.source, packet.sequence); lost > 0) {
    counters_->rx.lost.add(lost);
  }
  if (!accepts_all_ && !accept_.accepts(packet)) {
    counters_->rx.not_accepted.add();
    counters_->rx.not_accepted_messages.add(packet.message_id, packet.source, now);
    return false;
  }
  counters_->rx.messages.add(packet.message_id, packet.source, now);
  switchboard_.stream_time().on_packet(packet, [&] { deliver(now); });
  return true;
}

/// Counts, taps and logs a packet that has its route.
void Ingress::account(const Route& route, const mav::PacketView& packet, base::RunTime now) {
  if (counters_->ledger) counters_->ledger->received(route.info);
  counters_->rx.decisions[static_cast<std::size_t>(route.decision)].add();
  count_refusals(route);
  switchboard_.taps().on_packet(link_, packet, now);
  switchboard_.echo().on_packet(route.info, now);
  StreamTime& stream = switchboard_.stream_time();
  if (route.decision != Route::Decision::kDuplicate && switchboard_.tlog().listens()) {
    switchboard_.tlog().record(packet.bytes, stream.enabled() ? stream.now() : now);
  }
}

void Ingress::count_refusals(const Route& route) {
  using enum Route::Decision;
  if (route.held > 0) [[unlikely]] {
    counters_->count_refused(kNotHil, route.info, route.held);
    tell_held(route);
  }
  if (!route.thinned.empty()) {
    counters_->count_refused(kRateLimited, route.info, route.thinned.count());
  } else if (is_refusal(route.decision) && route.decision != kNotHil) {
    counters_->count_refused(route.decision, route.info);
  }
}

/// Writes one line per link, because a played log may have thousands of such packets.
void Ingress::tell_held(const Route& route) {
  if (std::exchange(told_held_, true)) return;
  base::log::warn(fmt::format(
      "link {}: message {} of {}/{} and others like it are held back: they may spin, move, drop or "
      "mislead a vehicle that does not say it is in HIL (to_not_hil: all lets them pass)",
      counters_->name, route.info.message_id, route.info.source.system,
      route.info.source.component));
}

void Ingress::deliver(base::RunTime now) {
  if (batch_.empty()) return;
  if (auto ports = switchboard_.ports_after(ports_generation_)) ports_ = std::move(ports);
  if (const std::size_t lost = batch_.deliver(*ports_, now); lost > 0) [[unlikely]] {
    counters_->rx.no_memory.add(lost);
  }
}

void Ingress::tick(base::RunTime now) { switchboard_.router().tick(link_, now); }

void Ingress::count_parser(const Parser& parser, const Parser::Stats& before) {
  const Parser::Stats& after = parser.stats();
  if (after.crc_errors != before.crc_errors) {
    counters_->rx.crc_errors.add(after.crc_errors - before.crc_errors);
  }
  if (after.skipped_bytes != before.skipped_bytes) {
    counters_->rx.skipped_bytes.add(after.skipped_bytes - before.skipped_bytes);
  }
  if (after.unknown_ids != before.unknown_ids) {
    counters_->rx.unknown.add(after.unknown_ids - before.unknown_ids);
  }
}

}  // namespace cas::casd
