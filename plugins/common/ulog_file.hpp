// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/time/clock.hpp"

namespace cas::sim {

/// One topic of a log: its name and its fields after the timestamp, "float[3] gyro_rad;float x".
/// One without fields is not in the log.
struct UlogTopic {
  std::string_view name;
  std::string_view fields;
};

/// Fields of topic `wing_groundtruth`, as both logs of a flight have it.
std::string wing_fields(int surfaces);

/// A fact about the whole log, as its key (type and name) and the bytes of its value.
struct UlogInfo {
  std::string key;
  std::string value;

  static UlogInfo text(std::string_view name, std::string_view value);
  static UlogInfo int32(std::string_view name, std::int32_t value);
  static UlogInfo uint32(std::string_view name, std::uint32_t value);
};

/// A parameter of the vehicle; ULog knows int32_t and float.
struct UlogParam {
  std::string name;
  bool is_integer = false;
  double value = 0;
};

/// The bytes of one logged message, in the order of the topic's fields; the timestamp comes first.
class UlogRecord {
 public:
  explicit UlogRecord(base::SimTime time) { put(base::to_time_usec(time)); }

  template <class T>
  UlogRecord& put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    CAS_CHECK(size_ + sizeof value <= bytes_.size());
    std::memcpy(bytes_.data() + size_, &value, sizeof value);
    size_ += sizeof value;
    return *this;
  }
  UlogRecord& put_float(double value) { return put(static_cast<float>(value)); }
  /// Each coefficient of an Eigen vector as float.
  template <class Vector>
  UlogRecord& put_floats(const Vector& vector) {
    for (int i = 0; i < vector.size(); ++i) put_float(vector[i]);
    return *this;
  }
  std::span<const std::uint8_t> bytes() const { return {bytes_.data(), size_}; }

 private:
  std::array<std::uint8_t, 128> bytes_;
  std::size_t size_ = 0;
};

/// Writes a log in PX4's ULog format, version 1 (docs.px4.io, "ULog File Format"), which
/// PlotJuggler, Flight Review and pyulog read.
class UlogFile {
 public:
  UlogFile() = default;
  /// Writes header and definitions; topic i gets the message id i. The system's name is CAS.
  ///
  /// @param params  as they were when the log began
  /// @throws base::ConfigError
  UlogFile(base::ResultPlace place, std::span<const UlogTopic> topics,
           std::span<const UlogInfo> infos = {}, std::span<const UlogParam> params = {});

  void write(std::uint16_t topic, const UlogRecord& record);
  /// A parameter that has another value from here on.
  void write(const UlogParam& param);
  /// A sentence of the vehicle. @param severity  MAV_SEVERITY, 0 to 7: that of syslog, too
  void write_text(base::SimTime time, int severity, std::string_view text);
  /// @throws base::ConfigError when the data did not reach the disk
  void close();

 private:
  void write_header();
  void write_pair(char type, std::string_view key, std::string_view value);
  void write_message(char type, std::span<const std::uint8_t> head,
                     std::span<const std::uint8_t> body);

  base::OpenFile file_;
  base::ResultPlace place_;
};

}  // namespace cas::sim
