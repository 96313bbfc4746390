// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "mavlink_gen/json/message_codec.hpp"

namespace cas::casd {

/// Fields and values of messages: of the project's dialect, and of MAVLink XML read at run time.
using MessageDecoder = mav::services::MessageCodec;

/// Reads a dialect and its includes into the decoder.
/// @throws base::ConfigError with file and line of the error
void add_dialect(const std::filesystem::path& xml, MessageDecoder& decoder);

}  // namespace cas::casd
