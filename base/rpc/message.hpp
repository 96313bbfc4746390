// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

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

/// A method. Called on the server's io thread with the parameters (object or array, null when
/// absent).
using Method = std::function<void(const Json& params, Reply reply)>;

}  // namespace cas::base::rpc
