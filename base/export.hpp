// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Symbols that the shared library cas_base offers; everything else is hidden.
#define CAS_BASE_EXPORT __attribute__((visibility("default")))
