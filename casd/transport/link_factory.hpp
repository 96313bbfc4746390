// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "casd/link/link.hpp"
#include "casd/link/link_core.hpp"

namespace cas::casd {

/// Makes the link that a configuration asks for. It opens itself once its loop runs.
std::unique_ptr<Link> make_link(LinkContext context);

}  // namespace cas::casd
