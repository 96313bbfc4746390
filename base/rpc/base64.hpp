// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace cas::base::rpc {

/// Bytes as a text that JSON and pages take: base 64 (RFC 4648, Sect. 4).
std::string to_base64(std::string_view bytes);
/// The bytes of such a text, up to the first character that is none of its digits.
std::string from_base64(std::string_view text);

}  // namespace cas::base::rpc
