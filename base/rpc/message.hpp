// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/export.hpp"

/// JSON-RPC 2.0 (https://www.jsonrpc.org/specification), one object a line.
namespace cas::base::rpc {

using Json = nlohmann::json;

/// Codes of the specification, and ours from -32000 down.
enum ErrorCode : int {
  kParseError = -32700,
  kInvalidRequest = -32600,
  kMethodNotFound = -32601,
  kInvalidParams = -32602,
  kInternalError = -32603,
  kRefused = -32000,  ///< the vehicle refused; data has MAV_RESULT and its status text
  kTimeout = -32001,
  kNoSuchVehicle = -32002,
  kNotAuthorised = -32003,
  kInterlock = -32004,  ///< the vehicle does not say that it is in HIL
};

/// An error as the answer of a call: a client throws the answer it got, a method may throw the one
/// it answers (run_answered()).
class CAS_BASE_EXPORT CallError : public std::runtime_error {
 public:
  CallError(int code, const std::string& message, std::string data_json = "null")
      : std::runtime_error(message), code_(code), data_json_(std::move(data_json)) {}
  int code() const { return code_; }
  const std::string& data_json() const { return data_json_; }

 private:
  int code_;
  std::string data_json_;
};
/// Parameters that a method cannot work with; the sentence goes to the client.
class CAS_BASE_EXPORT BadParams : public CallError {
 public:
  explicit BadParams(const std::string& message) : CallError(kInvalidParams, message) {}
};

/// Why a server ends a connection, or does not begin it.
enum class Refusal {
  kNone,
  kNotJsonRpc,  ///< a line was no JSON, no request, or too long
  kWrongToken,
  kNoRequest,  ///< no request came in time, or none that authorised where a token is asked for
  kNoPlace,    ///< the places, or the share of the client's address, were taken
};

/// Answers one call, now or later, once, on the server's thread.
struct Reply {
  std::function<void(Json result)> result;
  std::function<void(int code, std::string message, Json data)> error;
  std::string client{};  ///< the caller, for an audit: "127.0.0.1:40412", "unix:uid 1000"
};

/// Runs the body of a method and answers with an error if it throws: a CallError with its own code,
/// a ConfigError as refused, a JSON value of the wrong type as wrong parameters.
/// @return the sentence of the error; nullopt: the body returned
CAS_BASE_EXPORT std::optional<std::string> run_answered(const Reply& reply,
                                                        const std::function<void()>& body);

/// A method, see run_answered(). Called on the server's io thread with the parameters (object or
/// array, null when absent).
using Method = std::function<void(const Json& params, Reply reply)>;

}  // namespace cas::base::rpc
