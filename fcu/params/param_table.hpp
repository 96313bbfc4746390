// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "base/config/vehicle.hpp"
#include "fcu/estimation/estimator_params.hpp"
#include "fcu/params/params.hpp"
#include "fcu/params/settings.hpp"

namespace cas::fcu {

/// All parameters of an airframe with their defaults and ranges, unsorted.
/// @param figures  of the sensors' data sheets: the estimator's defaults
/// @param delay_s  from the gyro to the motors: the gains' defaults
std::vector<Param> default_params(const base::Vehicle& vehicle, const EstimatorParams& figures,
                                  double delay_s);

/// The settings that the values of a store stand for.
Settings read_settings(const ParamStore& store);

}  // namespace cas::fcu
