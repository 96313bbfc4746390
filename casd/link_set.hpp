// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "casd/counters/link_counters.hpp"
#include "casd/link/link_core.hpp"
#include "casd/link/link_home.hpp"
#include "casd/link/link_loop.hpp"
#include "casd/link/switchboard.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/signing/link_signing.hpp"
#include "casd/topology/topology.hpp"
#include "casd/transport/local_endpoint.hpp"

namespace cas::casd {

/// All links of a topology at work: slots, threads, router, figures, and casd's own station.
///
///   topology --> slots --> RoutingPlan --> Router        (rules, replaced as a whole)
///                  |-----> Link on its LinkLoop          (LinkHome tells which)
///                  |-----> PortTable --> Switchboard     (where links find each other)
///
/// Made, changed and destroyed on casd's main thread.
class LinkSet {
 public:
  explicit LinkSet(Topology topology, RetryTimes retry = {});
  ~LinkSet();

  /// Opens everything.
  void start();
  /// Closes all links at once.
  void stop();
  /// Puts another topology in force. Links whose configuration has not changed keep running and
  /// lose nothing. All or nothing: @throws base::ConfigError for a change that needs a restart,
  /// std::exception when its links cannot be made (no descriptors, no threads); then the old
  /// topology stays in force with all its links
  /// @return the links that are gone; new ones may have their numbers
  LinkMask reload(Topology topology);

  const Topology& topology() const { return topology_; }
  LinkFigures& figures() { return figures_; }
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
    std::shared_ptr<LinkHome> home;
  };

  /// A link that is made but not in force: it does nothing, and no other link sends to it.
  struct Opening {
    Running running;
    std::shared_ptr<LinkCounters> counters;
    std::unique_ptr<Link> link;
  };
  /// Everything of a new topology except the links that stay.
  struct Change {
    std::vector<Opening> openings;
    std::shared_ptr<const RoutingPlan> plan;
    std::shared_ptr<const PortTable> ports;
    SigningKeys keys;
  };

  std::set<std::string> unchanged(const Topology& topology) const;
  /// Makes all new parts. Throws without having changed anything.
  Change prepare(const Topology& topology, const std::set<std::string>& kept);
  Opening make_opening(const Topology& topology, const LinkConfig& config, LinkId id,
                       const SigningKeys& keys);
  void commit(Change change);
  void close(const std::string& name);
  std::shared_ptr<LinkHome> home_for(const Topology& topology, const LinkConfig& config);

  const RetryTimes retry_;
  Topology topology_;
  Switchboard switchboard_;
  LinkFigures figures_;
  SigningKeys keys_;
  std::shared_ptr<LocalEndpoint> local_;
  std::shared_ptr<LinkLoop> common_loop_;  ///< threads: auto, single, blocking
  std::map<std::string, Running> running_;
  bool started_ = false;
};

}  // namespace cas::casd
