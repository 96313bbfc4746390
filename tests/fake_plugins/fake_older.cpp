// SPDX-License-Identifier: BSD-3-Clause
// Of the ABI of CAS 0.1.0, whose vehicles had four rotors.
#include "tests/fake_plugins/idle.hpp"

#undef CAS_ABI_TAG
#define CAS_ABI_TAG CAS_ABI_BUILD ";cas=0.1"

CAS_PLUGIN(cas::test::Idle, "fake_older")
