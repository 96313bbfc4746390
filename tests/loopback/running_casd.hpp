// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {

inline const std::string kCasdProgram = binary_dir() + "/bin/casd";
/// Of a topology: a free port that a test commands casd by.
inline const std::string kOpenPort = "command_port: {port: 0, loopback_without_token: true}\n";

/// The real casd, once it is ready, and a client of its command port.
class RunningCasd : public ChildProcess {
 public:
  /// @param command  kCasdProgram and its arguments
  /// @throws std::runtime_error with its output when it does not get ready
  explicit RunningCasd(const std::vector<std::string>& command) : ChildProcess(command) {
    const std::optional<std::string> ready = wait_ready();
    if (!ready) throw std::runtime_error(output());
    status = *ready;
  }

  /// Of the command port.
  std::string address() const { return word_after(status, "command_port"); }
  /// Where a link was bound when casd was ready; also of "command_port" and "metrics".
  std::uint16_t port(const std::string& name) const { return port_of(word_after(status, name)); }

  nlohmann::json call(const std::string& method,
                      const nlohmann::json& params = nlohmann::json::object()) {
    return client().call(method, params);
  }
  base::rpc::Client& client() {
    if (!client_) client_.emplace(address());
    return *client_;
  }
  /// The sentence of a refusal; empty: none.
  std::string refusal(const std::string& method,
                      const nlohmann::json& params = nlohmann::json::object()) {
    try {
      call(method, params);
    } catch (const base::rpc::CallError& error) {
      return error.what();
    }
    return "";
  }
  /// As link.list has it; nullopt: there is none.
  std::optional<nlohmann::json> find_link(const std::string& name) {
    for (const nlohmann::json& link : call("link.list")) {
      if (link["name"] == name) return link;
    }
    return std::nullopt;
  }
  /// The same of one that is there. @throws std::bad_optional_access
  nlohmann::json link(const std::string& name) { return find_link(name).value(); }
  /// Runs the real casctl.
  Ended casctl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {binary_dir() + "/bin/casctl", "--address", address()});
    return ChildProcess(arguments).end();
  }

  std::string status;  ///< of READY

 private:
  std::optional<base::rpc::Client> client_;
};

}  // namespace cas::test
