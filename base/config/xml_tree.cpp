// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/xml_tree.hpp"

#include <expat.h>

#include <fmt/format.h>
#include <algorithm>
#include <memory>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cas::base {

namespace {

constexpr std::size_t kDeepest = 200;
constexpr std::size_t kMostElements = 1'000'000;  // with attributes: a few hundred megabytes

/// The elements that are open, from the root inwards.
struct Builder {
  XmlElement top;  // holds the root
  std::vector<XmlElement*> open{&top};
  XML_Parser parser = nullptr;
  std::shared_ptr<const std::string> file;
  std::size_t elements = 0;
  std::string refusal;

  void refuse(std::string sentence) {
    refusal = std::move(sentence);
    XML_StopParser(parser, XML_FALSE);
  }

  static void on_start(void* user, const XML_Char* name, const XML_Char** attributes) {
    auto& self = *static_cast<Builder*>(user);
    if (!self.refusal.empty()) return;  // expat ends after this element
    if (self.open.size() > kDeepest) {
      return self.refuse(fmt::format("elements lie more than {} deep", kDeepest));
    }
    if (++self.elements > kMostElements) {
      return self.refuse(
          fmt::format("has more than the {} elements and attributes that are read", kMostElements));
    }
    XmlElement& element = self.open.back()->children.emplace_back();
    element.name = name;
    element.line = static_cast<int>(XML_GetCurrentLineNumber(self.parser));
    element.file = self.file;
    for (; *attributes != nullptr; attributes += 2, ++self.elements)
      element.attributes[attributes[0]] = attributes[1];
    self.open.push_back(&element);
  }
  static void on_end(void* user, const XML_Char*) {
    auto& self = *static_cast<Builder*>(user);
    if (self.refusal.empty()) self.open.pop_back();
  }
  static void on_text(void* user, const XML_Char* text, int length) {
    static_cast<Builder*>(user)->open.back()->text.append(text, static_cast<std::size_t>(length));
  }
};

/// Generated files may still hold the template's lines in comments.
std::string without_comments(std::string_view text) {
  constexpr std::string_view kBegin = "<!--";
  constexpr std::string_view kEnd = "-->";
  std::string rest;
  for (;;) {
    const std::size_t begin = text.find(kBegin);
    rest += text.substr(0, begin);
    if (begin == text.npos) return rest;
    const std::size_t end = text.find(kEnd, begin + kBegin.size());
    if (end == text.npos) return rest;
    text.remove_prefix(end + kEnd.size());
  }
}

/// @param what  holds the numbers: "<pose>"
std::vector<double> numbers_in(const XmlElement& at, const std::string& what, std::string_view text,
                               std::size_t count) {
  std::vector<double> values;
  if (const auto word = read_numbers(text, values)) {
    at.fail(what + " is not made of numbers: " + no_number(*word));
  }
  if (values.size() != count) {
    at.fail(fmt::format("{} has {} numbers instead of {}", what, values.size(), count));
  }
  return values;
}

/// Why expat has refused the text.
std::string fault_of(const Builder& builder) {
  if (!builder.refusal.empty()) return builder.refusal;
  const XML_Error error = XML_GetErrorCode(builder.parser);
  const std::string words = XML_ErrorString(error);
  if (error == XML_ERROR_UNKNOWN_ENCODING) return words + ": save the file as UTF-8";
  if (error != XML_ERROR_NO_ELEMENTS && error != XML_ERROR_UNCLOSED_TOKEN &&
      error != XML_ERROR_PARTIAL_CHAR && error != XML_ERROR_UNCLOSED_CDATA_SECTION) {
    return words;
  }
  if (builder.open.size() == 1) return words + ": the file is empty, or cut";
  const XmlElement& last = *builder.open.back();
  return fmt::format("{}: the file is cut, it ends within <{}> of line {}", words, last.name,
                     last.line);
}

}  // namespace

std::string_view XmlElement::attribute(std::string_view key) const {
  const auto found = attributes.find(key);
  return found == attributes.end() ? std::string_view() : std::string_view(found->second);
}

const XmlElement* XmlElement::child(std::string_view child_name) const {
  const auto found = std::find_if(children.begin(), children.end(),
                                  [&](const XmlElement& each) { return each.name == child_name; });
  return found == children.end() ? nullptr : &*found;
}

const XmlElement& XmlElement::need(std::string_view child_name) const {
  const XmlElement* const found = child(child_name);
  if (found == nullptr) fail("<" + name + "> has no <" + std::string(child_name) + ">");
  return *found;
}

std::string_view XmlElement::child_text(std::string_view child_name) const {
  const XmlElement* const found = child(child_name);
  return found != nullptr ? without_space(found->text) : std::string_view();
}

std::string XmlElement::place() const { return fmt::format("{}:{}", *file, line); }

void XmlElement::fail(const std::string& sentence) const {
  throw ConfigError(place() + ": " + sentence);
}

std::vector<double> XmlElement::numbers(std::size_t count) const {
  return numbers_in(*this, "<" + name + ">", text, count);
}

std::vector<double> XmlElement::numbers(std::string_view key, std::size_t count) const {
  return numbers_in(*this, "'" + std::string(key) + "' of <" + name + ">", attribute(key), count);
}

std::string_view without_space(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kNumberSpace);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kNumberSpace) - first + 1);
}

std::optional<std::string> template_language(std::string_view with_comments) {
  const std::string text = without_comments(with_comments);
  const auto has = [&text](std::string_view mark) { return text.find(mark) != text.npos; };
  if (has("<xacro:")) {
    return "it is a xacro file, a template; expand it first: xacro FILE.xacro > FILE";
  }
  if (has("<%") || has("{%")) {
    return "it is a template with <% %> or {% %} in it; run the program that fills it in first";
  }
  return std::nullopt;
}

XmlElement parse_xml(std::string_view text, const std::string& file) {
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), &XML_ParserFree);
  Builder builder;
  builder.parser = parser.get();
  builder.file = std::make_shared<const std::string>(file);
  XML_SetUserData(parser.get(), &builder);
  XML_SetElementHandler(parser.get(), Builder::on_start, Builder::on_end);
  XML_SetCharacterDataHandler(parser.get(), Builder::on_text);
  if (XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE) !=
      XML_STATUS_OK) {
    throw ConfigError(
        fmt::format("{}:{}: {}", file, XML_GetCurrentLineNumber(parser.get()), fault_of(builder)));
  }
  return std::move(builder.top.children.front());
}

}  // namespace cas::base
