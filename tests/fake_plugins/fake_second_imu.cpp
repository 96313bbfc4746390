// SPDX-License-Identifier: BSD-3-Clause
// Declares a message that is the loop's own.
#include "tests/fake_plugins/idle.hpp"

CAS_PLUGIN(cas::test::Idle, "fake_second_imu")
CAS_PLUGIN_SENDS("HIL_SENSOR")
