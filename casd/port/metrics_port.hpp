// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "casd/port/metrics.hpp"

namespace cas::casd {

/// A small HTTP server that answers GET /metrics on a low-priority thread of its own. It takes no
/// lock of a packet's path: it gets a copy of the figures.
///
///   client --GET--> metrics thread --ask, 4 times a second at most--> main thread
///          <--page--              <--copy of them--
///
/// The number of clients, at once and in a second, is bounded, and each has a deadline; the oldest
/// gives way to a new one. Requests within a quarter of a second get the same page.
class MetricsPort {
 public:
  /// Takes the figures, from any thread.
  using Take = std::function<void(MetricsSource)>;
  /// Asks for the figures, which come now or later; called on the thread of the port.
  using Ask = std::function<void(Take)>;

  explicit MetricsPort(Ask ask);
  ~MetricsPort();
  MetricsPort(const MetricsPort&) = delete;
  MetricsPort& operator=(const MetricsPort&) = delete;

  /// Starts the thread, once. @param port  0 takes a free one
  /// @return the bound port @throws base::ConfigError
  std::uint16_t listen(const std::string& address, std::uint16_t port);
  /// Ends all connections and the thread.
  void close();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cas::casd
