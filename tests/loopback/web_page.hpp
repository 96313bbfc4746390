// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cas::test {

/// An answer of HTTP.
struct HttpAnswer {
  int status = 0;  ///< 0: none came
  std::map<std::string, std::string> headers{};
  std::string body{};
};

/// One request on a connection of its own. @param method  "GET"
HttpAnswer http_request(std::uint16_t port, const std::string& method, const std::string& target,
                        const std::string& host);

/// A page of casweb: a WebSocket that keeps received frames. Each wait ends after kPatience.
class WebPage {
 public:
  /// @param origin  empty: none is sent
  WebPage(std::uint16_t port, const std::string& host, const std::string& origin);
  /// As the page does.
  explicit WebPage(std::uint16_t port);
  ~WebPage();

  /// Status of a refused upgrade; 0: it is open.
  int refusal() const { return refusal_; }
  /// Calls and waits for the answer, an object with `result` or `error`. @throws std::runtime_error
  nlohmann::json call(const std::string& method, const nlohmann::json& params);
  /// Says hello with a proof of the token, as the page does. @return the last answer
  nlohmann::json hello(const std::string& token);
  /// The first half of it: casweb's nonce, kept for the proof. @return the answer
  nlohmann::json exchange_nonces();
  /// Proof for these nonces. @param place  where the page was opened; empty: where it was
  std::string proof(const std::string& token, const std::string& place = {}) const;
  /// Sends a text as it is.
  void send(const std::string& text);
  /// The next frame that is wanted, others are kept for later waits; nullopt at the deadline or
  /// when the connection has ended.
  std::optional<nlohmann::json> wait_for(const std::function<bool(const nlohmann::json&)>& wanted);
  /// The next `snap.TOPIC` or event's parameters.
  std::optional<nlohmann::json> next(const std::string& method);
  /// Acknowledges a snapshot.
  void ack(const std::string& topic, const nlohmann::json& params);
  /// Waits until the other end closes. @return its code
  std::optional<int> wait_closed();
  /// Received frames that no call waited for.
  const std::vector<nlohmann::json>& kept() const { return kept_; }

 private:
  std::optional<nlohmann::json> read();

  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string host_;
  std::string own_nonce_;
  std::string nonce_;  // casweb's
  int refusal_ = 0;
  int last_id_ = 0;
  std::vector<nlohmann::json> kept_;
};

}  // namespace cas::test
