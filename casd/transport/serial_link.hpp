// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/link/held_packets.hpp"
#include "casd/link/link_core.hpp"
#include "casd/link/tx_port.hpp"
#include "casd/transport/baud_search.hpp"
#include "casd/transport/path_watch.hpp"

namespace cas::casd {

/// A serial line, or a PTY. When the device goes away the link waits for its path to come back, by
/// back-off and by watching the folder; packets that waited for the old line are dropped.
///
/// With several baud rates it listens at each in turn and sends nothing until packets come. It does
/// so again when only unreadable bytes come for five seconds.
class SerialLink final : public Link {
 public:
  explicit SerialLink(LinkContext context);
  ~SerialLink() override { port_->detach(base::steady_now()); }

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void open(base::RunTime now);
  void listen(short events, base::RunTime now);
  void begin(base::Descriptor line, base::RunTime now);
  void read(base::RunTime now);
  void read_blocking(base::RunTime now);
  void end_pause(base::RunTime now);
  void check_rate(std::size_t bytes, std::uint64_t packets_before, base::RunTime now);
  void close(const std::string& reason, base::RunTime now);

  LinkCore core_;
  std::shared_ptr<TxPort> port_;
  PathWatch path_watch_;
  BaudSearch search_;
  base::Descriptor unattached_;  ///< the line during the search of its rate
  Parser parser_;
  StreamPause pause_;
  std::vector<std::uint8_t> buffer_;
  OpenDescriptor fd_;  ///< owned by the port's writer, or `unattached_`
  base::RunTime opened_at_{};
  base::RunTime tried_at_{};
  std::size_t poll_entry_ = 0;
};

}  // namespace cas::casd
