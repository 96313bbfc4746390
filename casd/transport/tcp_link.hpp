// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"
#include "casd/link/held_packets.hpp"
#include "casd/link/link_core.hpp"
#include "casd/link/log_thinning.hpp"
#include "casd/link/tx_port.hpp"
#include "casd/routing/route_table.hpp"
#include "casd/routing/router.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

/// A TCP connection that we open, and open again whenever it is gone. Of a name with several
/// addresses each is tried in turn.
class TcpLink final : public Link {
 public:
  explicit TcpLink(LinkContext context);
  ~TcpLink() override { port_->detach(base::steady_now()); }

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void connect(base::RunTime now);
  void finish_connect(base::RunTime now);
  bool find_addresses(base::RunTime now);
  void connect_to(const SocketAddress& address, base::RunTime now);
  void try_next(const std::string& reason, base::RunTime now);
  void serve_connected(short events, base::RunTime now);
  void read(base::RunTime now);
  void close(const std::string& reason, base::RunTime now);

  LinkCore core_;
  std::shared_ptr<TxPort> port_;
  Parser parser_;
  StreamPause pause_;
  std::vector<std::uint8_t> buffer_;
  AddressLookup remote_;
  bool looking_up_ = false;
  std::size_t tried_ = 0;  ///< addresses of the name, in this attempt
  base::Descriptor connecting_;
  base::RunTime connect_deadline_{};
  std::optional<base::RunTime> connected_at_;
  Backoff before_connection_{RetryTimes()};  ///< as it was when the connection was made
  OpenDescriptor fd_;                        ///< owned by the port's writer, or `connecting_`
  std::size_t poll_entry_ = 0;
};

/// Hands each packet to the clients that are to have it. Each client has a TxPort of its own, with
/// its own locks and queue, so that one that stops reading costs the others nothing. The lock here
/// is shared by all who write and only keeps the table of clients from changing meanwhile.
class TcpFanOut final : public PacketPort {
 public:
  explicit TcpFanOut(LinkId own) : own_(own), routes_(Router::kRouteLifetime) {}

  void deliver(std::span<const PacketRef> packets, base::RunTime now) override;

  // The link's thread:
  void set_client(PeerId client, std::shared_ptr<TxPort> port);
  void remove_client(std::uint8_t client, DropCause cause);
  RouteTable& routes() { return routes_; }

 private:
  SlotMask wanted_by(const PacketInfo& info) const CAS_REQUIRES_SHARED(mutex_);
  void deliver_to(std::uint8_t client, std::span<const PacketRef> packets,
                  std::span<const SlotMask> wanted, base::RunTime now) CAS_REQUIRES_SHARED(mutex_);

  LinkId own_;
  RouteTable routes_;
  base::SharedMutex mutex_;
  std::array<std::shared_ptr<TxPort>, kSlots> clients_ CAS_GUARDED_BY(mutex_);
  std::array<std::uint32_t, kSlots> serials_ CAS_GUARDED_BY(mutex_){};
  SlotMask present_ CAS_GUARDED_BY(mutex_) = 0;
};

/// A TCP port for several clients. When all places are taken, a client that never sent a whole
/// packet makes room for a new one, the oldest first. A client whose first byte begins no packet is
/// closed and nothing of it is parsed: a page in a browser may reach this port with a request whose
/// body is MAVLink.
class TcpServerLink final : public Link {
 public:
  explicit TcpServerLink(LinkContext context);
  ~TcpServerLink() override;

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  std::shared_ptr<PacketPort> port() override { return fan_out_; }

 private:
  struct Client {
    std::uint8_t slot = 0;
    std::uint32_t serial = 0;
    OpenDescriptor fd;  ///< owned by the port's writer
    std::shared_ptr<TxPort> port;
    Parser parser = make_parser();
    StreamPause pause;
    std::size_t poll_entry = 0;
    bool speaks_mavlink = false;  ///< its first byte has come and begins a packet
    bool was_heard = false;       ///< a whole packet has come
    std::string name;
  };

  void listen(base::RunTime now);
  base::Descriptor open_listener(const SocketAddress& address) const;
  void accept(int listener, base::RunTime now);
  /// @return why the client is to be closed; nothing: it stays
  std::optional<std::string> serve_client(Client& client, short events, base::RunTime now);
  std::optional<std::string> read(Client& client, base::RunTime now);
  void take_packet(Client& client, const mav::PacketView& packet, base::RunTime now);
  void remove(std::size_t index, const std::string& reason, base::RunTime now);
  void log_removal(const std::string& client, const std::string& reason, base::RunTime now);
  /// @return whether there is a place for one more client
  bool make_place(base::RunTime now);
  /// Clients that come and go may be many: their lines are thinned out.
  void log_thinned(const std::string& line, base::RunTime now);

  LinkCore core_;
  std::shared_ptr<TcpFanOut> fan_out_;
  AddressLookup local_;
  bool looking_up_ = false;
  struct Listener {
    base::Descriptor socket;
    OpenDescriptor watched;  ///< `socket` for a PollSet
    std::size_t poll_entry = 0;
  };
  std::vector<Listener> listeners_;
  base::RunTime accept_again_{};
  std::vector<std::unique_ptr<Client>> clients_;
  SlotMask slots_ = 0;
  std::uint32_t serials_ = 0;  ///< given so far
  bool told_of_strangers_ = false;
  LogThinning thinning_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace cas::casd
