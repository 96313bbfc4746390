// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/control/loop_design.hpp"
#include "fcu/estimation/estimator_params.hpp"

namespace cas::fcu {

enum class ParamType : std::uint8_t { kInt32, kReal32 };

/// One parameter: a name as PX4 has it (where PX4 has the same thing), its value and its bounds.
struct Param {
  std::string name;  ///< at most 16 characters
  ParamType type = ParamType::kReal32;
  double value = 0;    ///< representable in its wire type
  double initial = 0;  ///< default
  double start = 0;    ///< initial value from the configuration
  double low = 0;
  double high = 0;
};

enum class ParamSetResult { kOk, kUnknown, kOutOfRange, kNotANumber };

/// The controller's parameters, sorted by name. Defaults that depend on the airframe (gains, hover
/// thrust) are computed from the vehicle file.
class ParamStore {
 public:
  /// @param estimator  figures of the sensors' data sheets
  /// @param delay_s    from the gyro to the motors, for which gains are derived
  explicit ParamStore(const base::Vehicle& vehicle, const EstimatorParams& estimator = {},
                      double delay_s = kUsualDelay_s);

  std::size_t size() const { return params_.size(); }
  const Param& at(std::size_t index) const { return params_[index]; }
  std::optional<std::size_t> index_of(std::string_view name) const;

  /// Value of a parameter that exists (checked).
  double get(std::string_view name) const;
  int get_int(std::string_view name) const { return static_cast<int>(get(name)); }

  /// Sets a value; out of bounds or not a number leaves the old one in force.
  ParamSetResult set(std::string_view name, double value);
  void reset_to_defaults();

  /// Counts up with every change.
  std::uint64_t revision() const { return revision_; }

  /// Takes the present values as those that the configuration begins with.
  void mark_start();
  /// Values that differ from the start, as "NAME VALUE" lines.
  std::string changed_text() const;
  /// All values, as "NAME VALUE" lines.
  std::string all_text() const;

  /// CRC-32 over names and values in list order, as a ground station's cache compares it.
  std::uint32_t hash() const;

  /// The bytes of the value as its wire type (INT32 or REAL32), in a float field.
  static float to_wire(const Param& param);
  /// Value from the bytes of a float field.
  static double from_wire(ParamType type, float field);

 private:
  std::vector<Param> params_;
  std::uint64_t revision_ = 0;
};

}  // namespace cas::fcu
