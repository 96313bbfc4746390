// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "casd/link/link_core.hpp"
#include "casd/tlog/tlog_files.hpp"
#include "casd/tlog/tlog_read_ahead.hpp"

namespace cas::casd {

/// Plays a telemetry log as if its packets came in now, in the rhythm in which they were recorded;
/// a recorder's clock that was set meanwhile does not change it (TlogClock). Nothing can be sent to
/// it. A log without a packet is played once: it is not opened again.
class TlogLink final : public Link {
 public:
  explicit TlogLink(LinkContext context);

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void open(base::RunTime now);
  void begin(base::RunTime now);
  void play(base::RunTime now);
  void advance();
  void end(base::RunTime now);
  std::string damage_text() const;

  LinkCore core_;
  std::shared_ptr<PacketPort> port_;
  Parser parser_;
  std::unique_ptr<TlogReadAhead> log_;  ///< nullptr: not open
  bool begun_ = false;                  ///< its first record is there
  std::optional<TlogReadAhead::Record> next_;
  TlogClock clock_;
  base::RunTime started_{};  ///< when the first record is played
  base::RunTime due_{};      ///< of `next_`
  bool ended_ = false;
};

}  // namespace cas::casd
