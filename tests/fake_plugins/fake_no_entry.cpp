// SPDX-License-Identifier: BSD-3-Clause

// A library, but no plugin: it lacks the entry point.
extern "C" __attribute__((visibility("default"))) int cas_plugin_v0();
extern "C" int cas_plugin_v0() { return 0; }
