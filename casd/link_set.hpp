// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>

#include "casd/link_loop.hpp"
#include "casd/link_signing.hpp"
#include "casd/local_endpoint.hpp"
#include "casd/monitor.hpp"
#include "casd/switchboard.hpp"
#include "casd/topology.hpp"

namespace cas::casd {

/// All links of a topology at work: slots, threads, router, monitor, and casd's own station.
///
///   topology --> slots --> RoutingPlan --> Router        (rules, replaced as a whole)
///                  |-----> Link on its LinkLoop          (one thread each, or one for all)
///                  |-----> PortTable --> Switchboard     (where links find each other)
///
/// Made, changed and destroyed on casd's main thread.
class LinkSet {
 public:
  explicit LinkSet(Topology topology);
  ~LinkSet();

  /// Opens everything.
  void start();
  /// Closes everything; what was begun is not finished.
  void stop();
  /// Puts another topology in force. Links whose configuration has not changed keep running and
  /// lose nothing. @throws base::ConfigError when it asks for what only a restart can change; then
  /// the old one stays in force
  void reload(Topology topology);

  const Topology& topology() const { return topology_; }
  Monitor& monitor() { return monitor_; }
  LocalEndpoint& local() { return *local_; }
  TlogWriter& tlog() { return switchboard_.tlog(); }
  MessageTaps& taps() { return switchboard_.taps(); }
  EchoLatency& echo() { return switchboard_.echo(); }
  StreamTime& stream_time() { return switchboard_.stream_time(); }
  /// Has every link tried to open once?
  bool settled() const;
  /// Whether every link's thread still turns: ask once a second.
  bool alive(base::RunTime now);
  /// "sim 127.0.0.1:14561 fcu /dev/ttyACM0 921600".
  std::string endpoints() const;

 private:
  struct Running {
    LinkConfig config;
    LinkId id = kNoLink;
    std::shared_ptr<PacketPort> port;
    Link* link = nullptr;  ///< owned by its loop
    std::shared_ptr<LinkLoop> loop;
  };

  void open(const LinkConfig& config);
  void close(const std::string& name);
  LinkId free_slot() const;
  std::shared_ptr<LinkLoop> loop_for(const LinkConfig& config);
  LinkSlots slots() const;
  void publish_ports();

  Topology topology_;
  Switchboard switchboard_;
  Monitor monitor_;
  SigningKeys keys_;
  std::shared_ptr<LocalEndpoint> local_;
  std::shared_ptr<LinkLoop> common_loop_;  ///< threads: single, blocking
  std::map<std::string, Running> running_;
  bool started_ = false;
};

}  // namespace cas::casd
