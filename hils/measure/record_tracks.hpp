// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/measure/run_record.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

/// One record of a run, read from its begin to its end. RecordTracks merges several into one
/// stream.
class RecordTrack {
 public:
  virtual ~RecordTrack() = default;
  /// Simulated time of the next entry; nullopt at the end.
  virtual std::optional<base::SimTime> next() const = 0;
  /// Hands it over and goes on. @throws base::ConfigError when the file cannot be read on
  virtual void use_next() = 0;
};

/// The files of a run as one stream in order of simulated time, for the writers of logs.
class RecordTracks {
 public:
  using UseRow = std::function<void(base::SimTime, std::span<const double>)>;
  using UsePacket = std::function<void(base::SimTime, const mav::PacketView&)>;

  /// A CSV file with the time in its first column, in s.
  /// @param file     one that is not there has no rows: no such sensor
  /// @param columns  that a row has at least
  void add_csv(const std::filesystem::path& file, std::size_t columns, UseRow use);
  /// The flight log, at the simulated time of arrival at casd, which never goes back. Intact
  /// packets of known messages only.
  /// @param record  outlives this object
  void add_tlog(const RunRecord& record, UsePacket use);
  void add(std::unique_ptr<RecordTrack> track) { tracks_.push_back(std::move(track)); }

  /// Hands over every entry; those of one moment in the order in which the tracks were added.
  /// @throws base::ConfigError when a file cannot be read to its end
  void run();

 private:
  std::vector<std::unique_ptr<RecordTrack>> tracks_;
};

}  // namespace cas::hils
