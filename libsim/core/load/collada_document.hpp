// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/config/xml_tree.hpp"
#include "base/number_text.hpp"

namespace cas::sim {

/// The elements of a COLLADA file and their ids. Its errors are "FILE:LINE: ...".
class ColladaDocument {
 public:
  /// @throws base::ConfigError for a text that is no COLLADA file
  ColladaDocument(std::string_view text, std::string file);

  const base::XmlElement& root() const { return root_; }

  /// "FILE:LINE" of an element.
  std::string place(const base::XmlElement& element) const;
  [[noreturn]] void fail(const base::XmlElement& at, const std::string& sentence) const;

  /// The element of this name that "#id" in an attribute means. It is looked for among the
  /// children of `scope` first, if there is one: exporters give the sources of every geometry the
  /// same ids. @throws base::ConfigError when there is none, or more than one, and for an element
  /// of another file
  const base::XmlElement& target(const base::XmlElement& element, std::string_view key,
                                 std::string_view name,
                                 const base::XmlElement* scope = nullptr) const;

  /// All numbers of an element's text, which must be `count` if that is not 0.
  template <class Number>
  std::vector<Number> numbers(const base::XmlElement& element, std::size_t count = 0) const {
    std::vector<Number> all;
    if (const auto word = base::read_numbers(element.text, all)) refuse_word(element, *word);
    if (count != 0 && all.size() != count) refuse_count(element, all.size(), count);
    return all;
  }

  /// An attribute that is a number.
  template <class Number>
  Number number(const base::XmlElement& element, std::string_view key) const {
    std::string_view text = element.attribute(key);
    const auto value = base::number_of<Number>(base::next_word(text));
    if (!value || !base::next_word(text).empty()) refuse_attribute(element, key);
    return *value;
  }
  template <class Number>
  Number number(const base::XmlElement& element, std::string_view key, Number fallback) const {
    return element.attribute(key).empty() ? fallback : number<Number>(element, key);
  }

  /// Refuses an element that is not among those that may be left out.
  void require_known(const base::XmlElement& element,
                     std::initializer_list<std::string_view> may_be_left_out) const;

 private:
  void index(const base::XmlElement& element, const base::XmlElement* parent);
  [[noreturn]] void refuse_word(const base::XmlElement& at, std::string_view word) const;
  [[noreturn]] void refuse_count(const base::XmlElement& at, std::size_t is,
                                 std::size_t wanted) const;
  [[noreturn]] void refuse_attribute(const base::XmlElement& at, std::string_view key) const;

  std::string file_;
  base::XmlElement root_;
  // By name of the element, as geometries and their nodes often share an id, and by its parent;
  // nullptr: anywhere in the file.
  using Id = std::tuple<std::string_view, std::string_view, const base::XmlElement*>;
  std::map<Id, std::vector<const base::XmlElement*>> by_id_;
};

}  // namespace cas::sim
