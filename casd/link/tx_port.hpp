// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "base/os/mutex.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/link/link.hpp"
#include "casd/link/standstill.hpp"
#include "casd/packet/own_numbers.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/queue/tx_queue.hpp"

namespace cas::casd {

class LinkSigning;

/// Settings of a TxPort: its queue, and rate and caps of its line.
struct TxPortOptions {
  TxQueueOptions queue = {};
  double line_bytes_s = 0;                    ///< rate of the line that writes are held to; 0: none
  double cap_bytes_s = 0;                     ///< cap that the topology sets; 0: none
  base::Duration sensor_gap{};                ///< least time between two HIL_SENSOR; 0: none
  bool flow_control = false;                  ///< the other side may hold the line
  std::shared_ptr<LinkSigning> signing = {};  ///< may be empty
  bool own_numbers = true;  ///< casd's own packets are numbered for this link alone
};

/// The sending side of a link: one writer, the pacer of the line behind it, and the queue of
/// packets that wait for both. Whether a thread writes at once or waits for the line is decided by
/// the class derived from it: DirectTxPort, BlockingTxPort.
///
/// The port reads no clock: time is an argument, and the writer says when a write was over. So the
/// bench on the virtual clock sends with these classes, too.
///
/// What was written can still grow old in the driver, or in the terminal of a reader that has
/// stopped. So a line that stands still gets nothing more until it moves again.
///
/// Two locks: `writer_mutex_` guards what writes (descriptor, begun packet, pacer) and is held
/// during the system call; `queue_mutex_` guards the queue and is held for a copy only.
class TxPort : public PacketPort {
 public:
  // The link's thread only:

  /// Starts writing to a newly opened descriptor; the queue of the old one is dropped.
  /// @param line_bytes_s  rate of the line behind it, 0: none; nothing: that of the options
  void attach(std::unique_ptr<PacketWriter> writer, base::RunTime now,
              std::optional<double> line_bytes_s = {});
  /// The descriptor is gone; what waits is dropped.
  void detach(base::RunTime now, DropCause cause = DropCause::kClosed);
  /// Writes what waits, as far as descriptor and pacer allow.
  virtual void carry_on(base::RunTime now) = 0;
  /// The descriptor took no more: wait for POLLOUT, then carry_on().
  bool wants_room() const { return busy_.load(std::memory_order_relaxed); }
  /// When the pacer allows the next packet; PollSet::kNever when nothing waits for it.
  base::RunTime due() const;
  /// The other side has sent something: it lives, though it need not read.
  void heard(base::RunTime now);
  /// A write found the descriptor broken.
  bool broken() const { return broken_.load(std::memory_order_relaxed); }
  /// Since when something waits that cannot be written; nothing while it moves.
  std::optional<base::RunTime> stuck_since() const;

 protected:
  /// @param pacer_slack  how far ahead of time the line may be given bytes
  /// @param wake         called when the link's thread must call carry_on(); from any thread
  TxPort(const TxPortOptions& options, base::Duration pacer_slack,
         std::shared_ptr<LinkCounters> counters, std::function<void()> wake);

  /// Writes packets to the descriptor and counts them. @return how many are gone or begun
  std::size_t write_some(std::span<const PacketRef> packets, base::RunTime now)
      CAS_REQUIRES(writer_mutex_);
  /// Writes the rest of a begun packet. @return true when none is left
  bool write_tail(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  bool has_tail() const CAS_REQUIRES(writer_mutex_) { return tail_at_ < tail_packet_.size(); }
  /// Fills the batch from the queue. @return false when nothing may be written now
  bool take_batch(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  /// Whether the pacer lets the next packet out.
  bool line_ready(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  void drop_all(DropCause cause, base::RunTime now) CAS_REQUIRES(writer_mutex_);
  /// Makes the link's thread call carry_on() when the descriptor takes bytes again.
  void wait_for_room(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  /// Whether the other side has made no way for longer than a HIL packet is worth sending, although
  /// it was given something. What is written then would only grow old where nobody can drop it.
  bool stands_still(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  base::Duration patience(base::RunTime now) const CAS_REQUIRES(writer_mutex_);
  /// Cares for a line that stands still. @return when to look at it again
  base::RunTime tend_still_line(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  /// Packets of one read that are worth sending, in their order; good until the next call.
  std::span<const PacketRef> worth_sending(std::span<const PacketRef> packets, base::RunTime now)
      CAS_REQUIRES(writer_mutex_);

  // From any thread:
  void enqueue(std::span<const PacketRef> packets, base::RunTime now);
  bool anything_queued();
  void count_drop(const PacketInfo& info, DropCause cause, base::RunTime now);

  const TxPortOptions options_;
  const base::Duration pacer_slack_;
  const std::shared_ptr<LinkCounters> counters_;
  const std::function<void()> wake_;

  base::Mutex writer_mutex_;
  std::unique_ptr<PacketWriter> writer_ CAS_GUARDED_BY(writer_mutex_);
  LinePacer pacer_ CAS_GUARDED_BY(writer_mutex_);
  std::atomic<bool> capped_{false};  ///< the pacer holds to the topology's cap, not to the line
  LineCheck line_check_ CAS_GUARDED_BY(writer_mutex_);
  /// The packet that was begun, and how much of it is gone.
  std::vector<std::uint8_t> tail_packet_ CAS_GUARDED_BY(writer_mutex_);
  std::size_t tail_at_ CAS_GUARDED_BY(writer_mutex_) = 0;
  PacketInfo tail_info_ CAS_GUARDED_BY(writer_mutex_);
  /// The check of the begun packet was made wrong, and the packet counted as dropped.
  bool tail_spoilt_ CAS_GUARDED_BY(writer_mutex_) = false;
  OwnNumbers own_numbers_ CAS_GUARDED_BY(writer_mutex_);
  std::vector<PacketRef> worth_sending_ CAS_GUARDED_BY(writer_mutex_);
  Standstill standstill_ CAS_GUARDED_BY(writer_mutex_);
  std::vector<std::uint8_t> batch_bytes_ CAS_GUARDED_BY(writer_mutex_);
  std::vector<PacketInfo> batch_infos_ CAS_GUARDED_BY(writer_mutex_);
  /// Taken from the queue, about to be written.
  std::vector<PacketRef> batch_ CAS_GUARDED_BY(writer_mutex_);
  std::size_t batch_at_ CAS_GUARDED_BY(writer_mutex_) = 0;

  // May be taken while writer_mutex_ is held, never the other way.
  base::Mutex queue_mutex_;
  base::RunTime queue_time_ CAS_GUARDED_BY(queue_mutex_);  ///< of the call that works on the queue
  TxQueue queue_ CAS_GUARDED_BY(queue_mutex_);

  std::atomic<bool> open_{false};
  std::atomic<bool> backlog_{false};  ///< packets wait: no new one may overtake them
  std::atomic<bool> busy_{false};     ///< the descriptor takes no more for now
  std::atomic<bool> broken_{false};
  std::atomic<std::int64_t> heard_ns_{0};       ///< when the other side last sent something
  std::atomic<std::int64_t> due_ns_{0};         ///< 0: not held by the pacer
  std::atomic<std::int64_t> busy_since_ns_{0};  ///< 0: not busy

 private:
  void pace(double line_bytes_s) CAS_REQUIRES(writer_mutex_);
  void settle(std::span<const PacketRef> done, const WriteResult& result, base::RunTime now)
      CAS_REQUIRES(writer_mutex_);
  void account(std::span<const PacketRef> written, base::RunTime now, base::RunTime done)
      CAS_REQUIRES(writer_mutex_);
  void take_line(std::span<const PacketRef> written, base::RunTime now) CAS_REQUIRES(writer_mutex_);
  void begin_tail(const PacketRef& packet, std::size_t gone, base::RunTime now)
      CAS_REQUIRES(writer_mutex_);
  void drop_tail(DropCause cause, base::RunTime now) CAS_REQUIRES(writer_mutex_);
  void spoil_late_tail(base::RunTime now) CAS_REQUIRES(writer_mutex_);
  void wait_for_line() CAS_REQUIRES(writer_mutex_);
};

}  // namespace cas::casd
