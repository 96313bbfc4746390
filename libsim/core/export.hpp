// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Symbols that the shared library cas_sim offers; everything else is hidden.
#define CAS_SIM_EXPORT __attribute__((visibility("default")))
