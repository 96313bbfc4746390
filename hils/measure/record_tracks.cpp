// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/record_tracks.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "base/error.hpp"
#include "casd/tlog/tlog_files.hpp"
#include "hils/measure/csv_file.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

namespace {

using base::SimTime;

class CsvRecordTrack final : public RecordTrack {
 public:
  CsvRecordTrack(std::filesystem::path file, std::size_t columns, RecordTracks::UseRow use)
      : columns_(columns), csv_(std::move(file)), use_(std::move(use)) {
    read();
  }

  std::optional<SimTime> next() const override { return time_; }
  void use_next() override {
    use_(*time_, row_);
    read();
  }

 private:
  void read() {
    time_.reset();
    row_ = csv_.next(columns_);
    if (!row_.empty()) time_ = SimTime(base::from_seconds(row_.front()));
  }

  std::size_t columns_;
  CsvFile csv_;
  RecordTracks::UseRow use_;
  std::span<const double> row_;
  std::optional<SimTime> time_;
};

class TlogRecordTrack final : public RecordTrack {
 public:
  TlogRecordTrack(const RunRecord& record, RecordTracks::UsePacket use)
      : path_(record.flight_tlog),
        clock_(record.log_clock),
        use_(std::move(use)),
        parser_(mavlink::common::table()) {
    if (!log_.open(record.flight_tlog)) {
      throw base::ConfigError("cannot read " + record.flight_tlog.string());
    }
    read();
  }

  std::optional<SimTime> next() const override {
    return entry_ ? std::optional(time_) : std::nullopt;
  }
  void use_next() override {
    parser_.reset();  // a damaged record must not swallow the next one
    parser_.feed(entry_->packet, [this](const mav::PacketView& packet) { use_(time_, packet); });
    read();
  }

 private:
  void read() {
    entry_ = log_.next();
    if (log_.failed()) throw base::ConfigError("cannot read " + path_.string() + " to its end");
    if (!entry_) return;
    const std::int64_t us = clock_.to_sim_us(static_cast<std::int64_t>(entry_->unix_us));
    // A wall clock that is set back, or a log that begins before the simulation: time goes on.
    time_ = std::max(time_, SimTime(std::chrono::microseconds(us)));
  }

  const std::filesystem::path path_;
  const ClockMap& clock_;
  RecordTracks::UsePacket use_;
  casd::TlogReader log_;
  mav::PacketParser parser_;
  std::optional<casd::TlogReader::Record> entry_;
  SimTime time_{};
};

}  // namespace

void RecordTracks::add_csv(const std::filesystem::path& file, std::size_t columns, UseRow use) {
  tracks_.push_back(std::make_unique<CsvRecordTrack>(file, columns, std::move(use)));
}

void RecordTracks::add_tlog(const RunRecord& record, UsePacket use) {
  tracks_.push_back(std::make_unique<TlogRecordTrack>(record, std::move(use)));
}

void RecordTracks::run() {
  const auto time_of = [](const auto& track) { return track->next().value_or(SimTime::max()); };
  while (true) {
    const auto first = std::ranges::min_element(tracks_, {}, time_of);
    if (first == tracks_.end() || !(*first)->next()) break;
    (*first)->use_next();
  }
}

}  // namespace cas::hils
