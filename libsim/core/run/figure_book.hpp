// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "libsim/api/figure.hpp"
#include "libsim/api/topic_bus.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// Whose figure it is, and how it is shown.
struct FigureSpec {
  std::string vehicle;  ///< "iris0"
  std::string plugin;   ///< "battery", "battery#2"
  std::string name;     ///< "voltage"
  std::string unit;     ///< "V"
  FigureKind kind = FigureKind::kSeries;
};

/// A figure and its published values. A curve keeps at most `kMostPoints`, at first 20 ms apart;
/// when it is full, every second point is dropped and the distance doubles, so it spans a run of
/// any length.
class CAS_SIM_EXPORT FigureRecord {
 public:
  static constexpr std::size_t kMostPoints = 20'000;
  static constexpr base::Duration kPointPeriod = std::chrono::milliseconds(20);

  explicit FigureRecord(FigureSpec spec);

  void add(const FigureSample& sample);
  /// Back to nothing published.
  void reset();

  const FigureSpec& spec() const { return spec_; }
  std::uint64_t samples() const { return samples_; }        ///< finite ones
  std::uint64_t not_finite() const { return not_finite_; }  ///< that were left out
  const std::vector<std::pair<base::SimTime, double>>& points() const { return points_; }
  /// As an object of JSON.
  std::string json() const;

 private:
  FigureSpec spec_;
  std::uint64_t samples_ = 0;
  std::uint64_t not_finite_ = 0;
  double least_ = 0;
  double greatest_ = 0;
  double sum_ = 0;
  double last_ = 0;
  base::Duration period_ = kPointPeriod;
  std::vector<std::pair<base::SimTime, double>> points_;
};

/// The figures of all plugins of a run.
class CAS_SIM_EXPORT FigureBook {
 public:
  static constexpr std::size_t kMostOfAPlugin = 64;

  /// Opens a record and wires its topic. @throws base::ConfigError for a name or unit that cannot
  /// be shown, a name that the plugin has given before, and beyond kMostOfAPlugin
  Publisher<FigureSample> add(TopicBus& bus, FigureSpec spec);
  /// Forgets published values.
  void reset();

  bool empty() const { return records_.empty(); }
  /// The file of a run: {"schema": 1, "figures": [...]}.
  std::string json() const;

 private:
  std::vector<std::unique_ptr<FigureRecord>> records_;  // each where its subscription finds it
  std::vector<Subscription> subscriptions_;
};

}  // namespace cas::sim
