// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/link/link_core.hpp"
#include "casd/link/tx_port.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

/// Options of every TCP connection: no delay, dead peers found within seconds.
void prepare_tcp(int fd);

/// A TCP connection that we open, and open again whenever it is gone.
class TcpLink final : public Link {
 public:
  explicit TcpLink(LinkContext context);
  ~TcpLink() override { port_->detach(); }

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void connect(base::RunTime now);
  void finish_connect(base::RunTime now);
  void serve_connected(short events, base::RunTime now);
  void read(base::RunTime now);
  void close(const std::string& reason, base::RunTime now);

  LinkCore core_;
  std::shared_ptr<TxPort> port_;
  Parser parser_;
  std::vector<std::uint8_t> buffer_;
  AddressLookup remote_;
  bool looking_up_ = false;
  base::Descriptor connecting_;
  base::RunTime connect_deadline_{};
  int fd_ = -1;  ///< owned by the port's writer
  std::size_t poll_entry_ = 0;
};

}  // namespace cas::casd
