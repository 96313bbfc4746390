// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mavlink_gen/parser/model.hpp"
#include "mavlink_gen/runtime/message_table.hpp"

namespace cas::mav::xml {

/// The table of a dialect that is read at run time, for receivers and routers. Owns its names.
class DialectTable final {
 public:
  explicit DialectTable(const Dialect& dialect);
  DialectTable(const DialectTable&) = delete;
  DialectTable& operator=(const DialectTable&) = delete;

  const MessageTable& table() const { return table_; }

 private:
  std::vector<std::string> names_;
  std::vector<MessageInfo> messages_;
  std::vector<std::uint16_t> by_id_, by_name_;
  MessageTable table_;
};

}  // namespace cas::mav::xml
