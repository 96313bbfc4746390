// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/measure/histogram.hpp"
#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/counters/link_ledger.hpp"
#include "casd/counters/message_counters.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/queue/tx_queue.hpp"
#include "casd/routing/router.hpp"
#include "casd/words/link_words.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

enum class LinkState : std::uint8_t { kOpening, kUp, kDown };
std::string_view to_string(LinkState state);

/// A counter with one writer at a time and any number of readers.
class Counter {
 public:
  void add(std::uint64_t n = 1) {
    value_.store(value_.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
  }
  void set(std::uint64_t value) { value_.store(value, std::memory_order_relaxed); }
  std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// Forwarding times of one sending link by receiving link, at most 64 at a time; `others()` holds
/// the rest and those of removed links. Memory is taken with the first packet of a route. Callers
/// lock.
class RouteLatency {
 public:
  static constexpr std::size_t kMaxRoutes = 64;

  struct Figures {
    LinkId from = kNoLink;
    std::uint64_t count = 0;
    base::Duration p50{}, p99{}, max{};
  };

  void add(LinkId from, base::Duration time) {
    const bool known = from < times_.size() && (times_[from] || take_up(from));
    (known ? *times_[from] : others_).add(time);
  }

  /// The link is gone, and its id may become another link's.
  void forget(LinkId from) {
    if (!times_[from]) return;
    others_.merge(*times_[from]);
    times_[from].reset();
    --routes_;
  }
  /// Times of packets from removed links, and from those beyond the first 64.
  const base::Histogram& others() const { return others_; }
  /// How many links a packet came from.
  std::size_t routes() const { return routes_; }
  /// The times themselves, as many as `copies` has room for: figures are made without the lock.
  void copy(std::vector<std::pair<LinkId, base::Histogram>>& copies) const {
    for (std::size_t from = 0; from < times_.size(); ++from) {
      if (!times_[from] || copies.size() == copies.capacity()) continue;
      copies.emplace_back(static_cast<LinkId>(from), *times_[from]);
    }
  }
  static Figures figures(LinkId from, const base::Histogram& times) {
    return {.from = from,
            .count = times.count(),
            .p50 = times.quantile(0.50),
            .p99 = times.quantile(0.99),
            .max = times.max()};
  }

 private:
  bool take_up(LinkId from) {
    if (routes_ == kMaxRoutes) return false;
    times_[from] = std::make_unique<base::Histogram>();
    ++routes_;
    return true;
  }

  std::array<std::unique_ptr<base::Histogram>, kLinkSlots> times_;
  base::Histogram others_;
  std::size_t routes_ = 0;  ///< of them that are in use
};

/// A packet, rightly signed, whose time lies more than a minute ahead of casd's clock.
struct FutureSignature {
  mav::Source source;
  std::uint8_t link_id = 0;  ///< of the signature
  std::uint64_t time = 0;    ///< mav::SigningTime
  bool refused = false;
  base::RunTime at;
};

/// What a link counts of received packets; N is Counter, or a number for a copy.
template <class N>
struct RxCounts {
  N packets{}, bytes{}, crc_errors{}, lost{}, unknown{}, skipped_bytes{}, kernel_drops{}, foreign{};
  N not_accepted{};                       ///< left out by the link's `accept`
  N no_memory{};                          ///< lost because casd got no memory
  N setup_signing{};                      ///< refused: a key never goes on
  N signing_time{};                       ///< mav::SigningTime of the link's key
  std::array<N, 8> signatures{};          ///< by mav::SignatureVerdict, on links with `signing`
  std::array<N, kDecisions> decisions{};  ///< by Route::Decision: where they ended
};
/// Likewise of packets to be sent.
template <class N>
struct TxCounts {
  N packets{}, bytes{}, refused{}, queue_high_water{}, queued{}, write_calls{};
  std::array<N, kDropCauses> dropped{};  ///< by DropCause
};

/// What one link counts. `rx` fields are written by the link's thread, `tx` fields under
/// `tx.mutex`, which is held for the counting only; everybody may read.
struct LinkCounters {
  LinkCounters(std::string link_name, LinkType link_type)
      : name(std::move(link_name)), type(link_type) {}

  const std::string name;
  const LinkType type;
  std::atomic<LinkState> state{LinkState::kOpening};
  std::atomic<int> send_denied{0};  ///< why the last packet could not be sent; 0: it was
  Counter reconnects;
  Counter peers;  ///< of a server, now
  Counter baud;   ///< that a serial line was opened with last; 0: none

  /// HIL packets one by one; nothing unless asked for.
  std::unique_ptr<LinkLedger> ledger;

  struct : RxCounts<Counter> {
    std::array<MessageCounters, kRouterRefusals> refused;  ///< in the order of their DropCause
    MessageCounters messages;
    MessageCounters not_accepted_messages;  ///< of Counter not_accepted, not in `messages`
  } rx;
  struct : TxCounts<Counter> {
    std::array<MessageCounters, kDropCauses> dropped_messages;
    MessageCounters messages;
    mutable base::Mutex mutex;
    /// Read to written; read it through LinkFigures.
    RouteLatency forwarding CAS_GUARDED_BY(mutex);
  } tx;

  /// A received packet was not forwarded, or not to all that its route names.
  void count_refused(Route::Decision why, const PacketInfo& info, unsigned times = 1);
  /// Packets are written. @param done  when the write had returned
  void count_sent(std::span<const PacketRef> packets, base::RunTime now, base::RunTime done);
  /// The destination has refused packets that were sent.
  void count_tx_refused(std::uint64_t packets);
  /// Packets were sent, or this machine denied it: EPERM or EACCES, of a firewall or a service's
  /// rules. Other errors say nothing of that.
  void note_send(int error) {
    const bool denied = error == EPERM || error == EACCES;
    if (error != 0 && !denied) return;
    if (send_denied.load(std::memory_order_relaxed) == error) return;
    send_denied.store(error, std::memory_order_relaxed);
  }
  /// A packet was not sent.
  void count_dropped(const PacketInfo& info, DropCause cause, base::RunTime now);

  /// Words for state and errors ("127.0.0.1:14561", "/dev/ttyACM0", "No such file"), rarely set.
  void set_endpoint(std::string text);
  std::string endpoint() const;

  /// Where the time of signatures is kept; set once.
  void set_signing_file(std::string file);
  std::string signing_file() const;
  /// The newest one; nothing: none yet.
  void set_future_signature(const FutureSignature& signature);
  std::optional<FutureSignature> future_signature() const;

 private:
  mutable base::Mutex mutex_;
  std::string endpoint_ CAS_GUARDED_BY(mutex_);
  std::string signing_file_ CAS_GUARDED_BY(mutex_);
  std::optional<FutureSignature> future_signature_ CAS_GUARDED_BY(mutex_);
};

/// A link as `casd.status` and `link.list` report it.
struct LinkStatus {
  LinkId id = kNoLink;
  std::string name;
  LinkType type = LinkType::kUdp;
  LinkState state = LinkState::kOpening;
  std::string endpoint;
  std::uint64_t reconnects = 0;
  std::uint64_t peers = 0;
  std::uint64_t baud = 0;       ///< of a serial line that was open; 0: none
  std::uint64_t uncounted = 0;  ///< packets that no table by message and sender had room for
  struct : RxCounts<std::uint64_t> {
    std::string signing_file;  ///< where `signing_time` is kept
    std::optional<FutureSignature> future_signature;
  } rx;
  struct : TxCounts<std::uint64_t> {
    base::Duration forwarding_p50{}, forwarding_p99{}, forwarding_max{}, forwarding_mean{};
    std::vector<base::Histogram::Bin> forwarding;  ///< the whole distribution, by octaves
    std::vector<RouteLatency::Figures> routes;
  } tx;
};

/// A counter of a link: its words, and where it is counted and reported.
struct LinkCounterRow {
  const CounterWords& words;
  void (*read)(const LinkCounters& link, LinkStatus& status);
  std::uint64_t (*value)(const LinkStatus& status);
};
/// Every counter that is one number.
std::span<const LinkCounterRow> link_counter_rows();

/// What became of messages that a link counts together.
struct MessageWay {
  enum class Direction : std::uint8_t { kRx, kTx, kDrop };
  Direction direction = Direction::kRx;
  DropCause cause{};  ///< of kDrop; kNotAccepted: received and left out by the link's `accept`

  bool is_drop() const { return direction == Direction::kDrop; }
  auto operator<=>(const MessageWay&) const = default;
};
/// "rx", "tx", "drop." and the cause.
std::string to_string(MessageWay way);

/// One message of one sender on one link, as `message.list` reports it.
struct MessageStatus {
  std::string link;
  MessageWay way;
  std::uint32_t id = 0;
  std::string name;  ///< empty when no public dialect has it
  mav::Source source;
  std::uint64_t count = 0;
  double hz = 0;     ///< over the last seconds
  double age_s = 0;  ///< since the last one
};

/// A part of the messages: so many, from one on, in the order in which they were first heard. So
/// invented senders come behind those that were there before.
struct MessagePage {
  bool drops_only = false;
  std::size_t offset = 0;
  std::size_t limit = SIZE_MAX;
};

/// The figures of all links. The hot path only counts; rates are formed here, from two looks at the
/// counters. `sample`, `links` and `messages` belong to one thread (casd's main thread).
class LinkFigures {
 public:
  /// The counters of a link that is not in the figures yet.
  std::shared_ptr<LinkCounters> make_link(const std::string& name, LinkType type) const;
  void add_link(LinkId id, std::shared_ptr<LinkCounters> link) { links_[id] = std::move(link); }
  std::shared_ptr<LinkCounters> add_link(LinkId id, const std::string& name, LinkType type);
  void remove_link(LinkId id);
  /// The links remember each HIL packet, those that are added later too; before they start.
  void keep_ledgers();
  /// The ledgers of the links there are; to be read when these have stopped.
  std::map<std::string, const LinkLedger*> ledgers() const;

  /// Once a second: forms the rates.
  void sample(base::RunTime now);
  std::vector<LinkStatus> links() const;
  /// Name of a link; empty: there is none with this id.
  std::string name(LinkId id) const;
  /// Who sends a message to a link, and the link that it is heard on.
  /// Nothing: it was never sent there, or several do so, or it came over several links at the
  /// same time.
  std::optional<std::pair<mav::Source, LinkId>> sender_of(std::uint32_t message_id,
                                                          LinkId to) const;
  /// @param link  only of this one; nothing: all
  std::vector<MessageStatus> messages(base::RunTime now,
                                      const std::optional<std::string>& link = {},
                                      const MessagePage& page = {}) const;
  /// Packets that were dropped, of the links there are.
  std::uint64_t dropped() const;

 private:
  struct Rate {
    std::uint64_t count = 0;
    base::RunTime at;
    double hz = 0;
  };
  using RateKey = std::tuple<LinkId, MessageWay, std::uint64_t>;  // the last: key of the message
  struct Found {
    LinkId link = kNoLink;
    const LinkCounters* counters = nullptr;
    MessageWay way;
    MessageCounters::Entry entry;
  };

  void sample_counters(LinkId id, MessageWay way, const MessageCounters& counters,
                       base::RunTime now);
  std::vector<Found> found(base::RunTime now, const std::optional<std::string>& link,
                           bool drops_only) const;
  MessageStatus status_of(const Found& found, base::RunTime now) const;

  std::map<LinkId, std::shared_ptr<LinkCounters>> links_;
  std::map<RateKey, Rate> rates_;
  bool keeps_ledgers_ = false;
};

}  // namespace cas::casd
