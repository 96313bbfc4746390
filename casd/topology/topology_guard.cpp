// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include "base/config/config_whole.hpp"
#include "casd/topology/topology_parts.hpp"

namespace cas::casd {

AcceptRule parse_accept(const base::ConfigNode& node) {
  AcceptRule rule;
  if (!node.is_map()) {
    const auto word = node.as<std::string>();
    if (word != "nothing") node.fail("'" + word + "' is neither nothing nor {messages, systems}");
    rule.read_only = true;
    return rule;
  }
  if (const auto messages = node.find("messages")) rule.messages = parse_messages(*messages);
  rule.systems = parse_bytes(node, "systems");
  if (rule.messages.empty() && rule.systems.empty())
    node.fail("names neither messages nor systems");
  return rule;
}

SigningConfig parse_signing(const base::ConfigNode& node) {
  SigningConfig signing;
  signing.key_file = node.resolve(node.require<std::string>("key_file"));
  signing.link_id = base::get_whole_in<std::uint8_t>(node, "link_id", 0, 0, 255);
  signing.verify = node.get<bool>("verify", true);
  signing.sign = node.get<bool>("sign", true);
  if (const auto list = node.find("allow_unsigned")) {
    if (!signing.verify) list->fail("has no meaning without verify");
    signing.allow_unsigned = parse_messages(*list);
  }
  if (!signing.verify && !signing.sign) node.fail("neither verifies nor signs");
  return signing;
}

}  // namespace cas::casd
