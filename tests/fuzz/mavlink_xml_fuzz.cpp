// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a dialect: no crash, no hang; an accepted dialect can be written in every form.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mavlink_gen/generator/diff.hpp"
#include "mavlink_gen/generator/writers.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"
#include "mavlink_gen/parser/dialect_table.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cas::mav;
  xml::Diagnostics diagnostics;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto dialect = xml::parse_dialect(text, "fuzz", diagnostics);
  diagnostics.render();
  if (dialect.has_value() != (diagnostics.error_count() == 0)) std::abort();
  if (!dialect) return 0;
  gen::write_cpp(*dialect, "fuzz");
  gen::write_docs(*dialect);
  gen::write_json(*dialect);
  if (!gen::compare(*dialect, *dialect).empty()) std::abort();
  const xml::DialectTable table(*dialect);
  for (const auto& message : dialect->messages) {
    if (table.table().find(message.id) == nullptr) std::abort();
  }
  return 0;
}
