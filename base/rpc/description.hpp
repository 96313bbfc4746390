// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/export.hpp"
#include "base/rpc/message.hpp"

namespace cas::base::rpc {

/// Description of a port's methods, from the short form that a program writes:
///
///   {"title": "...",
///    "shapes":  {"Link": {"name": "string", "baud?": "integer"}},
///    "methods": {"link.list": {"summary": "...", "params": {"link?": "string: of the topology"},
///                              "result": ["Link"]}},
///    "topics":  {"links": {"summary": "...", "params": "Link"}}}
///
/// A shape is a word (integer, number, string, boolean, null, any, the name of a shape, or several
/// with | between them, and perhaps ": " and a sentence), an object whose keys are optional with a
/// ? at their end ("*" stands for any key), or a list of one shape: an array of it.
class CAS_BASE_EXPORT Description {
 public:
  /// Says nothing but the names.
  Description() = default;
  /// @param version  of the program
  /// @throws Json::exception where `text` is no such JSON
  Description(std::string_view text, std::string version);

  /// An OpenRPC document (https://spec.open-rpc.org) of these methods, in their order; topics are
  /// in `x-topics`. A method that the text does not describe has its name alone.
  Json document(const std::vector<std::string>& methods) const;

 private:
  std::shared_ptr<const nlohmann::ordered_json> text_;  ///< parameters stay in their order
  std::string version_;
};

/// The JSON Schema of a shape.
CAS_BASE_EXPORT Json schema_of(const Json& shape);

}  // namespace cas::base::rpc
