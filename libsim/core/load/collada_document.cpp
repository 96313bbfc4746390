// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/collada_document.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "base/error.hpp"

namespace cas::sim {

using base::XmlElement;

ColladaDocument::ColladaDocument(std::string_view text, std::string file)
    : file_(std::move(file)), root_(base::parse_xml(text, file_)) {
  if (root_.name != "COLLADA") throw base::ConfigError(file_ + ": is no COLLADA file");
  index(root_, nullptr);
}

void ColladaDocument::index(const XmlElement& element, const XmlElement* parent) {
  if (const auto id = element.attribute("id"); !id.empty()) {
    by_id_[{element.name, id, nullptr}].push_back(&element);
    if (parent != nullptr) by_id_[{element.name, id, parent}].push_back(&element);
  }
  for (const XmlElement& child : element.children) index(child, &element);
}

std::string ColladaDocument::place(const XmlElement& element) const {
  return fmt::format("{}:{}", file_, element.line);
}

void ColladaDocument::fail(const XmlElement& at, const std::string& sentence) const {
  throw base::ConfigError(place(at) + ": " + sentence);
}

const XmlElement& ColladaDocument::target(const XmlElement& element, std::string_view key,
                                          std::string_view name, const XmlElement* scope) const {
  std::string_view id = element.attribute(key);
  if (id.starts_with('#')) id.remove_prefix(1);
  auto found = scope != nullptr ? by_id_.find({name, id, scope}) : by_id_.end();
  if (found == by_id_.end()) found = by_id_.find({name, id, nullptr});
  const std::string what =
      "<" + element.name + "> names the <" + std::string(name) + "> '" + std::string(id) + "', ";
  if (found == by_id_.end()) {
    fail(element, what + (id.find('#') == id.npos ? "which the file does not have"
                                                  : "and other files are not read with this one"));
  }
  const std::vector<const XmlElement*>& all = found->second;
  if (all.size() > 1) {
    fail(element, fmt::format("{}and that id occurs twice, in lines {} and {}", what, all[0]->line,
                              all[1]->line));
  }
  return *all.front();
}

void ColladaDocument::require_known(const XmlElement& element,
                                    std::initializer_list<std::string_view> may_be_left_out) const {
  if (std::ranges::find(may_be_left_out, element.name) != may_be_left_out.end()) return;
  fail(element, "<" + element.name + "> is not read: without it the mesh has another shape");
}

void ColladaDocument::refuse_word(const XmlElement& at, std::string_view word) const {
  fail(at, "<" + at.name + ">: " + base::no_number(word));
}

void ColladaDocument::refuse_count(const XmlElement& at, std::size_t is, std::size_t wanted) const {
  fail(at, fmt::format("<{}> has {} numbers instead of {}", at.name, is, wanted));
}

void ColladaDocument::refuse_attribute(const XmlElement& at, std::string_view key) const {
  fail(at, "<" + at.name + ">: '" + std::string(key) + "': " + base::no_number(at.attribute(key)));
}

}  // namespace cas::sim
