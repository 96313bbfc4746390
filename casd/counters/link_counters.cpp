// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/link_counters.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/enum_words.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

constexpr auto kFirstRefusal = static_cast<std::size_t>(DropCause::kDuplicate);

template <class Visit>
void for_each_way(const LinkCounters& link, Visit&& visit) {
  using enum MessageWay::Direction;
  visit(MessageWay{kRx}, link.rx.messages);
  visit(MessageWay{kRx, DropCause::kNotAccepted}, link.rx.not_accepted_messages);
  visit(MessageWay{kTx}, link.tx.messages);
  for (std::size_t i = 0; i < link.tx.dropped_messages.size(); ++i) {
    visit(MessageWay{kDrop, static_cast<DropCause>(i)}, link.tx.dropped_messages[i]);
  }
  for (std::size_t i = 0; i < link.rx.refused.size(); ++i) {
    visit(MessageWay{kDrop, static_cast<DropCause>(kFirstRefusal + i)}, link.rx.refused[i]);
  }
}

std::uint64_t key_of(const MessageCounters::Entry& entry) {
  return std::uint64_t{entry.message_id} << 16U | std::uint64_t{entry.source.system} << 8U |
         entry.source.component;
}

template <std::size_t N>
void read(const std::array<Counter, N>& counters, std::array<std::uint64_t, N>& values) {
  for (std::size_t i = 0; i < N; ++i) values[i] = counters[i].get();
}

/// @tparam Member  from counters or their status to the address of one of them
template <class Member>
constexpr LinkCounterRow row(const CounterWords& words, Member /*member*/) {
  return {words,
          [](const LinkCounters& link, LinkStatus& status) {
            *Member{}(status) = Member{}(link)->get();
          },
          [](const LinkStatus& status) { return *Member{}(status); }};
}

void read_uncounted(const LinkCounters& link, LinkStatus& status) {
  for_each_way(link, [&status](MessageWay, const MessageCounters& counters) {
    status.uncounted += counters.uncounted();
  });
}

constexpr LinkCounterRow kRows[] = {
    row(counter_words("rx", "packets"), [](auto& link) { return &link.rx.packets; }),
    row(counter_words("rx", "bytes"), [](auto& link) { return &link.rx.bytes; }),
    row(counter_words("rx", "lost"), [](auto& link) { return &link.rx.lost; }),
    row(counter_words("rx", "crc_errors"), [](auto& link) { return &link.rx.crc_errors; }),
    row(counter_words("rx", "unknown"), [](auto& link) { return &link.rx.unknown; }),
    row(counter_words("rx", "skipped_bytes"), [](auto& link) { return &link.rx.skipped_bytes; }),
    row(counter_words("rx", "kernel_drops"), [](auto& link) { return &link.rx.kernel_drops; }),
    row(counter_words("rx", "foreign"), [](auto& link) { return &link.rx.foreign; }),
    row(counter_words("rx", "not_accepted"), [](auto& link) { return &link.rx.not_accepted; }),
    row(counter_words("rx", "no_memory"), [](auto& link) { return &link.rx.no_memory; }),
    row(counter_words("tx", "packets"), [](auto& link) { return &link.tx.packets; }),
    row(counter_words("tx", "bytes"), [](auto& link) { return &link.tx.bytes; }),
    row(counter_words("tx", "refused"), [](auto& link) { return &link.tx.refused; }),
    row(counter_words("tx", "queued"), [](auto& link) { return &link.tx.queued; }),
    row(counter_words("tx", "queue_high_water"),
        [](auto& link) { return &link.tx.queue_high_water; }),
    row(counter_words("tx", "write_calls"), [](auto& link) { return &link.tx.write_calls; }),
    row(counter_words("", "reconnects"), [](auto& link) { return &link.reconnects; }),
    {counter_words("", "uncounted"), read_uncounted,
     [](const LinkStatus& status) { return status.uncounted; }},
};

/// Each counter has one row; tx.dropped, an array by cause, has none.
consteval bool has_a_row_for_each_counter() {
  return std::ranges::all_of(kLinkCounters, [](const CounterWords& words) {
    const auto rows = std::ranges::count_if(
        kRows, [&words](const LinkCounterRow& row) { return &row.words == &words; });
    return rows == (words.kind == CounterWords::Kind::kByCause ? 0 : 1);
  });
}
static_assert(has_a_row_for_each_counter());

void read_rx(const LinkCounters& link, LinkStatus& status) {
  const auto& rx = link.rx;
  status.rx.setup_signing = rx.setup_signing.get();
  read(rx.decisions, status.rx.decisions);
  read(rx.signatures, status.rx.signatures);
  status.rx.signing_time = rx.signing_time.get();
  status.rx.signing_file = link.signing_file();
  status.rx.future_signature = link.future_signature();
}

void read_tx(const LinkCounters& link, LinkStatus& status) {
  const auto& tx = link.tx;
  read(tx.dropped, status.tx.dropped);
  // Senders wait for this lock: it is held for copies alone, never while memory is taken.
  base::Histogram forwarding;
  std::vector<std::pair<LinkId, base::Histogram>> routes;
  {
    base::MutexLock lock(tx.mutex);
    while (routes.capacity() < tx.forwarding.routes()) {
      const std::size_t count = tx.forwarding.routes();
      lock.unlock();
      routes.reserve(count);
      lock.lock();
    }
    forwarding = tx.forwarding.others();
    tx.forwarding.copy(routes);
  }
  for (const auto& [from, times] : routes) forwarding.merge(times);
  status.tx.forwarding_p50 = forwarding.quantile(0.50);
  status.tx.forwarding_p99 = forwarding.quantile(0.99);
  status.tx.forwarding_max = forwarding.max();
  status.tx.forwarding_mean = forwarding.mean();
  status.tx.forwarding = forwarding.octaves();
  for (const auto& [from, times] : routes) {
    status.tx.routes.push_back(RouteLatency::figures(from, times));
  }
}

}  // namespace

std::string_view to_string(LinkState state) {
  constexpr base::EnumWords<LinkState::kDown> kWords{"opening", "up", "down"};
  return kWords[state];
}

std::string to_string(MessageWay way) {
  constexpr base::EnumWords<MessageWay::Direction::kDrop> kWords{"rx", "tx", "drop."};
  std::string text(kWords[way.direction]);
  if (way.is_drop()) text += to_string(way.cause);
  return text;
}

std::span<const LinkCounterRow> link_counter_rows() { return kRows; }

void LinkCounters::set_endpoint(std::string text) {
  const base::MutexLock lock(mutex_);
  endpoint_ = std::move(text);
}

std::string LinkCounters::endpoint() const {
  const base::MutexLock lock(mutex_);
  return endpoint_;
}

void LinkCounters::set_signing_file(std::string file) {
  const base::MutexLock lock(mutex_);
  signing_file_ = std::move(file);
}

std::string LinkCounters::signing_file() const {
  const base::MutexLock lock(mutex_);
  return signing_file_;
}

void LinkCounters::set_future_signature(const FutureSignature& signature) {
  const base::MutexLock lock(mutex_);
  future_signature_ = signature;
}

std::optional<FutureSignature> LinkCounters::future_signature() const {
  const base::MutexLock lock(mutex_);
  return future_signature_;
}

void LinkCounters::count_refused(Route::Decision why, const PacketInfo& info, unsigned times) {
  MessageCounters& counters = rx.refused[static_cast<std::size_t>(cause_of(why)) - kFirstRefusal];
  for (unsigned i = 0; i < times; ++i) counters.add(info.message_id, info.source, info.received);
}

void LinkCounters::count_sent(std::span<const PacketRef> packets, base::RunTime now,
                              base::RunTime done) {
  std::size_t bytes = 0;
  const base::MutexLock lock(tx.mutex);
  for (const PacketRef& packet : packets) {
    bytes += packet.bytes.size();
    tx.messages.add(packet.info->message_id, packet.info->source, now);
    tx.forwarding.add(packet.info->from, done - packet.info->received);
    if (ledger) ledger->sent(*packet.info, done);
  }
  tx.packets.add(packets.size());
  tx.bytes.add(bytes);
}

void LinkCounters::count_tx_refused(std::uint64_t packets) {
  if (packets == 0) return;
  const base::MutexLock lock(tx.mutex);
  tx.refused.add(packets);
}

void LinkCounters::count_dropped(const PacketInfo& info, DropCause cause, base::RunTime now) {
  const auto index = static_cast<std::size_t>(cause);
  const base::MutexLock lock(tx.mutex);
  tx.dropped[index].add();
  tx.dropped_messages[index].add(info.message_id, info.source, info.received);
  if (ledger) ledger->dropped(info, cause, now);
}

std::shared_ptr<LinkCounters> LinkFigures::make_link(const std::string& name, LinkType type) const {
  auto link = std::make_shared<LinkCounters>(name, type);
  if (keeps_ledgers_) link->ledger = std::make_unique<LinkLedger>();
  return link;
}

std::shared_ptr<LinkCounters> LinkFigures::add_link(LinkId id, const std::string& name,
                                                    LinkType type) {
  auto link = make_link(name, type);
  add_link(id, link);
  return link;
}

void LinkFigures::keep_ledgers() {
  keeps_ledgers_ = true;
  for (const auto& [id, link] : links_) link->ledger = std::make_unique<LinkLedger>();
}

std::map<std::string, const LinkLedger*> LinkFigures::ledgers() const {
  std::map<std::string, const LinkLedger*> ledgers;
  for (const auto& [id, link] : links_) {
    if (link->ledger) ledgers[link->name] = link->ledger.get();
  }
  return ledgers;
}

void LinkFigures::remove_link(LinkId id) {
  links_.erase(id);
  for (const auto& [other, link] : links_) {
    const base::MutexLock lock(link->tx.mutex);
    link->tx.forwarding.forget(id);
  }
  std::erase_if(rates_, [id](const auto& entry) { return std::get<0>(entry.first) == id; });
}

void LinkFigures::sample(base::RunTime now) {
  for (const auto& [id, link] : links_) {
    for_each_way(*link, [&, link_id = id](MessageWay way, const MessageCounters& counters) {
      sample_counters(link_id, way, counters, now);
    });
  }
  std::erase_if(rates_, [now](const auto& entry) { return entry.second.at < now; });
}

void LinkFigures::sample_counters(LinkId id, MessageWay way, const MessageCounters& counters,
                                  base::RunTime now) {
  constexpr double kGain = 0.5;  // of the newest second: settles within a few
  for (const MessageCounters::Entry& entry : counters.kinds(now)) {
    const auto [found, fresh] = rates_.try_emplace({id, way, key_of(entry)});
    Rate& rate = found->second;
    const bool goes_on = !fresh && entry.count >= rate.count;  // else it was forgotten meanwhile
    if (!goes_on) rate.hz = 0;
    if (goes_on && now > rate.at) {
      const double hz =
          static_cast<double>(entry.count - rate.count) / base::to_seconds(now - rate.at);
      rate.hz = rate.hz == 0 ? hz : rate.hz + kGain * (hz - rate.hz);
    }
    rate.count = entry.count;
    rate.at = now;
  }
}

std::string LinkFigures::name(LinkId id) const {
  const auto found = links_.find(id);
  return found == links_.end() ? "" : found->second->name;
}

std::optional<std::pair<mav::Source, LinkId>> LinkFigures::sender_of(std::uint32_t message_id,
                                                                     LinkId to) const {
  const auto receiver = links_.find(to);
  if (receiver == links_.end()) return std::nullopt;
  constexpr base::Duration kStretch = std::chrono::seconds(5);
  std::vector<MessageCounters::Entry> senders;
  receiver->second->tx.messages.for_each([&](const MessageCounters::Entry& entry) {
    if (entry.message_id == message_id) senders.push_back(entry);
  });
  const auto newest = std::ranges::max_element(senders, {}, &MessageCounters::Entry::last);
  if (newest == senders.end()) return std::nullopt;
  for (const MessageCounters::Entry& sender : senders) {
    if (sender.source != newest->source && newest->last - sender.last < kStretch) {
      return std::nullopt;
    }
  }
  std::vector<LinkId> heard_on;
  for (const auto& [id, link] : links_) {
    link->rx.messages.for_each([&, from = id](const MessageCounters::Entry& entry) {
      if (entry.message_id != message_id || entry.source != newest->source) return;
      if (newest->last - entry.last < kStretch) heard_on.push_back(from);
    });
  }
  if (heard_on.size() != 1) return std::nullopt;
  return std::pair{newest->source, heard_on.front()};
}

std::vector<LinkStatus> LinkFigures::links() const {
  std::vector<LinkStatus> all;
  for (const auto& [id, link] : links_) {
    LinkStatus& status = all.emplace_back();
    status.id = id;
    status.name = link->name;
    status.type = link->type;
    status.state = link->state.load(std::memory_order_relaxed);
    status.endpoint = link->endpoint();
    status.peers = link->peers.get();
    status.baud = link->baud.get();
    for (const LinkCounterRow& each : kRows) each.read(*link, status);
    read_rx(*link, status);
    read_tx(*link, status);
  }
  return all;
}

std::vector<LinkFigures::Found> LinkFigures::found(base::RunTime now,
                                                   const std::optional<std::string>& link,
                                                   bool drops_only) const {
  std::vector<Found> all;
  for (const auto& [id, own] : links_) {
    if (link && own->name != *link) continue;
    for_each_way(*own,
                 [&, from = id, of = own.get()](MessageWay way, const MessageCounters& counters) {
                   if (drops_only && !way.is_drop()) return;
                   for (const MessageCounters::Entry& entry : counters.kinds(now)) {
                     all.push_back({.link = from, .counters = of, .way = way, .entry = entry});
                   }
                 });
  }
  return all;
}

MessageStatus LinkFigures::status_of(const Found& found, base::RunTime now) const {
  const MessageCounters::Entry& entry = found.entry;
  const auto rate = rates_.find({found.link, found.way, key_of(entry)});
  const mav::MessageInfo* known = mav::public_table().find(entry.message_id);
  return {.link = found.counters->name,
          .way = found.way,
          .id = entry.message_id,
          .name = known == nullptr ? "" : std::string(known->name),
          .source = entry.source,
          .count = entry.count,
          .hz = rate == rates_.end() ? 0 : rate->second.hz,
          .age_s = base::to_seconds(now - entry.last)};
}

std::vector<MessageStatus> LinkFigures::messages(base::RunTime now,
                                                 const std::optional<std::string>& link,
                                                 const MessagePage& page) const {
  std::vector<Found> rows = found(now, link, page.drops_only);
  std::ranges::stable_sort(rows, {}, [](const Found& row) { return row.entry.since; });
  std::vector<MessageStatus> all;
  for (std::size_t i = page.offset; i < rows.size() && all.size() < page.limit; ++i) {
    all.push_back(status_of(rows[i], now));
  }
  return all;
}

std::uint64_t LinkFigures::dropped() const {
  std::uint64_t total = 0;
  for (const auto& [id, link] : links_) {
    for_each_way(*link, [&total](MessageWay way, const MessageCounters& counters) {
      if (!way.is_drop()) return;
      total += counters.uncounted();
      counters.for_each([&total](const MessageCounters::Entry& entry) { total += entry.count; });
    });
  }
  return total;
}

}  // namespace cas::casd
