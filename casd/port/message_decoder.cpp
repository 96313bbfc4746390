// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/message_decoder.hpp"

#include "base/error.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"

namespace cas::casd {

void add_dialect(const std::filesystem::path& xml, MessageDecoder& decoder) {
  mav::xml::Diagnostics diagnostics;
  const auto dialect = mav::xml::load_dialect(xml, diagnostics);
  if (!dialect) throw base::ConfigError(diagnostics.render());
  decoder.add(*dialect);
}

}  // namespace cas::casd
