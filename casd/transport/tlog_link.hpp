// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "casd/link/link_core.hpp"
#include "casd/tlog/tlog_files.hpp"

namespace cas::casd {

/// Plays a telemetry log as if its packets came in now, in the rhythm in which they were recorded.
/// Nothing can be sent to it.
class TlogLink final : public Link {
 public:
  explicit TlogLink(LinkContext context);

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void open(base::RunTime now);
  void play(base::RunTime now);
  void advance();
  void end(base::RunTime now);

  LinkCore core_;
  std::shared_ptr<PacketPort> port_;
  Parser parser_;
  TlogReader reader_;
  std::optional<TlogReader::Record> next_;
  std::uint64_t first_us_ = 0;  ///< stamp of the first record
  base::RunTime started_{};     ///< when it was played
  base::RunTime due_{};         ///< of `next_`
  bool ended_ = false;
};

}  // namespace cas::casd
