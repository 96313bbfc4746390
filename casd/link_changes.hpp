// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "casd/link_set.hpp"
#include "casd/station/failure_injector.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/station_scheduler.hpp"

namespace cas::casd {

/// Changes of casd's links at run time: by a reload, or one link by the command port.
class LinkChanges {
 public:
  /// All outlive it.
  LinkChanges(boost::asio::io_context& io, LinkSet& links, VehicleCommander& commander,
              FailureInjector& failures, StationScheduler& scheduler)
      : io_(io), links_(links), commander_(commander), failures_(failures), scheduler_(scheduler) {}

  /// Puts the links and routes of a topology in force. @throws std::exception, and nothing has
  /// changed
  void apply(Topology topology);
  /// Adds a link, see with_link(). @return its name
  /// @throws base::ConfigError, and nothing has changed
  std::string add(const base::ConfigNode& request);
  /// @param force  also the link of an armed vehicle or of its simulator
  /// @throws base::ConfigError, and nothing has changed
  void remove(const std::string& name, bool force);
  /// Whether a link was added at run time.
  bool is_added(const std::string& link) const { return added_.contains(link); }
  /// After a reload: the file is the truth, links that were added at run time are gone unless it
  /// has them.
  void forget_added();
  /// Calls `then` once a link has tried to open, at the latest at `until`.
  void when_tried(const std::string& link, base::RunTime until,
                  std::function<void(const std::string&)> then);

 private:
  void apply_at_run_time(Topology topology);
  std::optional<std::string> need_in_flight(const std::string& link) const;

  boost::asio::io_context& io_;
  LinkSet& links_;
  VehicleCommander& commander_;
  FailureInjector& failures_;
  StationScheduler& scheduler_;
  std::set<std::string> added_;
};

}  // namespace cas::casd
