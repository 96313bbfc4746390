# SPDX-License-Identifier: BSD-3-Clause
# Exported package: find_package(cas) gives cas::base, cas::sim_api, cas::mavlink and cas_add_plugin().
