// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "casd/counters/link_counters.hpp"

namespace boost::asio {
class io_context;
}

namespace cas::casd {

/// What the metrics are made of.
struct MetricsSource {
  double uptime_s = 0;
  std::size_t clients = 0;
  /// Clients that the command port refused, by reason.
  std::vector<std::pair<const char*, std::uint64_t>> refused;
  std::vector<LinkStatus> links;
  std::vector<MessageStatus> messages;
};

/// The figures in Prometheus' text format 0.0.4: counters end in _total, units are seconds and
/// bytes.
std::string metrics_text(const MetricsSource& source);

/// A small HTTP server that answers GET /metrics. Everything on the thread of `io`; few clients at
/// a time, each with a deadline, so that none can hold it.
class MetricsPort {
 public:
  using Text = std::function<std::string()>;

  /// @param text  makes the answer's body
  MetricsPort(boost::asio::io_context& io, Text text);
  ~MetricsPort();
  MetricsPort(const MetricsPort&) = delete;
  MetricsPort& operator=(const MetricsPort&) = delete;

  /// @param port  0 takes a free one
  /// @return the bound port @throws base::ConfigError
  std::uint16_t listen(const std::string& address, std::uint16_t port);
  /// Ends all connections.
  void close();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cas::casd
