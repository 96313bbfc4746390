// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fake_plugins/idle.hpp"

CAS_PLUGIN(cas::test::Idle, "somebody_else")
