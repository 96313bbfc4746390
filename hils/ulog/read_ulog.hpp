// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cas::hils {

/// A number in the messages of a topic. Nested types and arrays are spread out:
/// "esc[2].esc_rpm".
struct UlogField {
  enum class Type : std::uint8_t {
    kInt8,
    kUint8,
    kInt16,
    kUint16,
    kInt32,
    kUint32,
    kInt64,
    kUint64,
    kFloat,
    kDouble,
    kBool,
    kChar
  };

  std::string name;
  Type type{};
  std::size_t offset = 0;  ///< of its bytes in a message
};

/// Messages of one topic, or of one of its instances: the second barometer is "sensor_baro[1]".
struct UlogSeries {
  std::string name;
  std::vector<UlogField> fields;  ///< without `timestamp` and padding
};

/// A parameter's value; both of its types are numbers.
struct UlogValue {
  std::string name;
  double value = 0;
};

/// Receives the contents of a log in their order from read_ulog(). The replay collects its page
/// with one.
class UlogListener {
 public:
  virtual ~UlogListener() = default;

  /// Moment at which the log begins, us. Comes first.
  virtual void on_start(std::uint64_t /*time_us*/) {}
  /// A fact that is a text: ver_hw, ver_sw.
  virtual void on_text_fact(std::string_view /*name*/, std::string_view /*value*/) {}
  virtual void on_parameter(const UlogValue& /*parameter*/) {}
  /// A message. @param bytes  base of UlogField::offset; it holds each field
  virtual void on_message(const UlogSeries& /*series*/, std::uint64_t /*time_us*/,
                          std::string_view /*bytes*/) {}
  /// A sentence of the vehicle. @param severity  0 (emergency) to 7
  virtual void on_sentence(std::uint64_t /*time_us*/, int /*severity*/, std::string_view /*text*/) {
  }
  /// Messages of this time are missing: the vehicle's storage did not keep up.
  virtual void on_dropout(int /*duration_ms*/) {}
  /// Bytes that are no message; reading goes on behind them.
  virtual void on_damage(std::size_t /*bytes*/) {}
  /// The log, or the part of it before appended data, ends within a message: so much of it is
  /// there.
  virtual void on_cut(std::size_t /*bytes*/) {}
};

/// A field of a message, as a number.
double ulog_number(const UlogField& field, std::string_view bytes);

/// Reads a log in PX4's ULog format, versions 0 and 1 (docs.px4.io, "ULog File Format"), with data
/// appended behind its end. A log that ends in the middle of a message is read up to there, and one
/// with damaged bytes goes on where messages of right sizes follow one another, or at a
/// synchronisation message. A type that is not known is skipped by its size. A message of a topic
/// that the log does not name, or one shorter than its topic, counts as damage.
/// @throws base::ConfigError if it is no such log or needs an unknown feature
void read_ulog(std::string_view bytes, UlogListener& listener);

}  // namespace cas::hils
