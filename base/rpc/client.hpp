// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/export.hpp"
#include "base/rpc/message.hpp"
#include "base/time/clock.hpp"

namespace cas::base::rpc {

/// Thrown by Client when it cannot connect, loses the connection or gets no answer in time;
/// timeout() tells the last case. An answer that is an error is a CallError.
class CAS_BASE_EXPORT ConnectionError : public std::runtime_error {
 public:
  ConnectionError(const std::string& message, bool timeout)
      : std::runtime_error(message), timeout_(timeout) {}
  bool timeout() const { return timeout_; }

 private:
  bool timeout_;
};

/// Why no Client can connect to this, as a clause behind it; empty: it is "unix:PATH" or
/// "HOST:PORT", whether anything is there or not.
CAS_BASE_EXPORT std::string address_fault(const std::string& address);

/// A blocking client for programs that do one thing at a time (casctl, hils, tests).
class CAS_BASE_EXPORT Client {
 public:
  /// "HOST:PORT" or "unix:PATH". @throws ConnectionError
  explicit Client(const std::string& address, Duration connect_timeout = std::chrono::seconds(2));
  ~Client();
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;

  /// Authorises over TCP without sending the token: the server must prove first that it knows one
  /// of these, and gets a proof in return (token_proof()).
  /// @return whether it proved it; if not, no proof was sent @throws CallError, ConnectionError
  bool authorise_by_proof(const std::vector<std::string>& tokens);

  /// @throws CallError, ConnectionError
  Json call(const std::string& method, const Json& params,
            Duration timeout = std::chrono::seconds(10));
  /// Takes a notification that comes while a call is under way.
  using OnNotification = std::function<void(const std::string& method, const Json& params)>;
  /// The same for a call that takes long: `silence` is the time without a notification.
  Json call(const std::string& method, const Json& params, Duration silence,
            const OnNotification& heard);
  /// Waits for the next notification. @return false when none came in time
  bool next_notification(std::string& method, Json& params, Duration timeout);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::base::rpc
