// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace cas::hils {

/// What of an MCAP file is not on the page.
struct McapLoss {
  std::optional<std::size_t> cut_at;  ///< byte of the record within which it ends
  std::uint64_t unreadable = 0;       ///< messages that are no JSON object
  std::map<std::string, std::uint64_t> other_encodings;  ///< messages by encoding, but JSON

  /// For a person; empty: nothing.
  std::string sentence() const;
};

/// Contents of an MCAP file for the page, from its JSON messages:
///
///   vehicles: of each its name, system, log, and where the file has them scene, truth and
///             reference. The log is that of MessageCollector, from channels /mavlink/NAME, and
///             every other channel as a message with its numbers
///   world:    shapes of foxglove.SceneUpdate that are no vehicle's
///   name, description, seed, architecture: of the run, if a run of ours wrote it
///   duration_s
///
/// A file of another writer without cas.Vehicle has one vehicle: the first autopilot that is heard,
/// or none but in name. Time counts from the first message.
/// @param name  for such a vehicle
/// @throws base::ConfigError when it cannot be read, or has no JSON message
nlohmann::ordered_json mcap_contents(std::string_view bytes, const std::string& name,
                                     McapLoss* loss = nullptr);

}  // namespace cas::hils
