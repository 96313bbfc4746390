// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cas::casctl {

/// One parameter that a file asks for.
struct ParamWish {
  std::string name;
  double value = 0;
  /// Component of a row of QGroundControl's file; 0: the file does not say.
  int component = 0;
};

/// The parameters of a file, in its order. Read are the files of `casctl param save`, MAVProxy and
/// ArduPilot (NAME VALUE), Mission Planner (NAME,VALUE) and QGroundControl (system, component,
/// name, value and type in columns), each with any ends of lines, with or without a byte order
/// mark, with comments behind '#', with decimal or 0x values. The system of QGroundControl's rows
/// is not looked at.
///
/// @param file  its name, for errors
/// @throws std::runtime_error  for a line that is none of these, naming it, for a file in UTF-16
/// and for one that holds no parameter
std::vector<ParamWish> parse_param_file(std::string_view text, const std::string& file);

}  // namespace cas::casctl
