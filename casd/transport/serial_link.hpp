// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/link/link_core.hpp"
#include "casd/link/tx_port.hpp"

namespace cas::casd {

/// Tells when something changes where a device is expected (inotify on the nearest folder that
/// exists), so that a link reopens the moment its device is back instead of at its next try.
class PathWatch {
 public:
  explicit PathWatch(std::filesystem::path path) : path_(std::move(path)) {}

  /// Starts to watch. Call again after each change: a missing folder may have come.
  void arm();
  void disarm() { inotify_.reset(); }
  /// To wait for POLLIN on; -1 when it cannot watch.
  int descriptor() const { return inotify_.get(); }
  /// Forgets the changes so far. @return true when there were any
  bool take_changes();

 private:
  std::filesystem::path path_;
  base::Descriptor inotify_;
};

/// A serial line, or a PTY. When the device goes away the link waits for its path to come back, by
/// back-off and by watching the folder; packets that waited for the old line are dropped.
class SerialLink final : public Link {
 public:
  explicit SerialLink(LinkContext context);
  ~SerialLink() override { port_->detach(); }

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void open(base::RunTime now);
  void read(base::RunTime now);
  void read_blocking(base::RunTime now);
  void close(const std::string& reason, base::RunTime now);

  LinkCore core_;
  std::shared_ptr<TxPort> port_;
  PathWatch path_watch_;
  Parser parser_;
  std::vector<std::uint8_t> buffer_;
  int fd_ = -1;  ///< owned by the port's writer
  std::size_t poll_entry_ = 0;
};

}  // namespace cas::casd
