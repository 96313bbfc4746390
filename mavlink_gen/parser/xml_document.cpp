// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/xml_document.hpp"

#include <expat.h>

#include <algorithm>
#include <limits>

namespace cas::mav::xml {

const Attribute* Element::find(std::string_view attribute) const {
  const auto it = std::find_if(attributes.begin(), attributes.end(),
                               [&](const Attribute& a) { return a.name == attribute; });
  return it == attributes.end() ? nullptr : &*it;
}

namespace {

constexpr std::size_t kMaxDepth = 32;
constexpr std::size_t kMaxElements = 100'000;  // common.xml has 9000

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

bool is_name_char(char c) { return !is_space(c) && c != '=' && c != '>' && c != '/'; }

/// Walks the bytes of one start tag and keeps count of lines and columns.
class TagCursor final {
 public:
  TagCursor(std::string_view text, std::size_t offset, Position position)
      : text_(text), offset_(offset), position_(position) {}

  bool done() const { return offset_ >= text_.size() || text_[offset_] == '>'; }
  char current() const { return text_[offset_]; }
  Position position() const { return position_; }

  void advance() {
    const auto byte = static_cast<unsigned char>(text_[offset_++]);
    if (byte == '\n') {
      ++position_.line;
      position_.column = 1;
    } else if ((byte & 0xC0U) != 0x80U) {  // continuation bytes belong to the character before them
      ++position_.column;
    }
  }

  std::string_view take_name() {
    const auto begin = offset_;
    while (!done() && is_name_char(current())) advance();
    return text_.substr(begin, offset_ - begin);
  }

  void skip_value() {
    while (!done() && current() != '"' && current() != '\'') advance();
    if (done()) return;
    const auto quote = current();
    advance();
    while (offset_ < text_.size() && current() != quote) advance();
    if (offset_ < text_.size()) advance();
  }

 private:
  std::string_view text_;
  std::size_t offset_;
  Position position_;
};

/// Expat tells where a tag starts but not where its attributes are: finds them in the tag's own
/// bytes.
void locate_attributes(std::string_view text, std::size_t tag_offset, Element& element) {
  TagCursor cursor(text, tag_offset, element.position);
  cursor.advance();    // '<'
  cursor.take_name();  // the element's own name
  while (!cursor.done()) {
    if (!is_name_char(cursor.current())) {
      cursor.advance();
      continue;
    }
    const auto position = cursor.position();
    const auto name = cursor.take_name();
    const auto it = std::find_if(element.attributes.begin(), element.attributes.end(),
                                 [&](const Attribute& a) { return a.name == name; });
    if (it != element.attributes.end()) it->position = position;
    cursor.skip_value();
  }
}

class Reader final {
 public:
  Reader(std::string_view text, std::uint32_t file, Diagnostics& diagnostics)
      : text_(text), file_(file), diagnostics_(diagnostics), parser_(XML_ParserCreate(nullptr)) {
    XML_SetUserData(parser_, this);
    XML_SetElementHandler(parser_, &Reader::on_start, &Reader::on_end);
    XML_SetCharacterDataHandler(parser_, &Reader::on_text);
    XML_SetStartDoctypeDeclHandler(parser_, &Reader::on_doctype);
  }
  ~Reader() { XML_ParserFree(parser_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  std::unique_ptr<Element> run() {
    if (text_.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
      diagnostics_.error({file_, 1, 1}, "the file is too large");
      return nullptr;
    }
    const auto status =
        XML_Parse(parser_, text_.data(), static_cast<int>(text_.size()), /*isFinal=*/1);
    if (status == XML_STATUS_OK && !stopped_) return std::move(root_);
    if (!stopped_) {
      diagnostics_.error(here(), std::string("the XML is not well formed: ") +
                                     XML_ErrorString(XML_GetErrorCode(parser_)));
    }
    return nullptr;
  }

 private:
  static Reader& self(void* user) { return *static_cast<Reader*>(user); }
  static void on_start(void* user, const char* name, const char** attributes) {
    self(user).start(name, attributes);
  }
  static void on_end(void* user, const char*) { self(user).end(); }
  static void on_text(void* user, const char* text, int size) {
    self(user).append_text({text, static_cast<std::size_t>(size)});
  }
  static void on_doctype(void* user, const char*, const char*, const char*, int) {
    self(user).stop("a document type declaration is not allowed in a dialect");
  }

  Position here() const {
    return {file_, static_cast<std::uint32_t>(XML_GetCurrentLineNumber(parser_)),
            static_cast<std::uint32_t>(XML_GetCurrentColumnNumber(parser_) + 1)};
  }

  void stop(std::string why) {
    if (stopped_) return;
    stopped_ = true;
    diagnostics_.error(here(), std::move(why));
    XML_StopParser(parser_, XML_FALSE);
  }

  void start(const char* name, const char** attributes) {
    if (stopped_) return;
    if (open_.size() >= kMaxDepth) return stop("elements are nested too deeply");
    if (++elements_ > kMaxElements) return stop("the file has more than 100000 elements");
    Element element;
    element.name = name;
    element.position = here();
    element.text_position = element.position;
    for (; *attributes != nullptr; attributes += 2) {
      element.attributes.push_back({attributes[0], attributes[1], element.position});
    }
    const auto offset = XML_GetCurrentByteIndex(parser_);
    if (offset >= 0 && !element.attributes.empty()) {
      locate_attributes(text_, static_cast<std::size_t>(offset), element);
    }
    if (open_.empty()) {
      root_ = std::make_unique<Element>(std::move(element));
      open_.push_back(root_.get());
    } else {
      auto& siblings = open_.back()->children;
      siblings.push_back(std::move(element));
      open_.push_back(&siblings.back());
    }
  }

  void end() {
    if (!stopped_) open_.pop_back();
  }

  void append_text(std::string_view text) {
    if (stopped_ || open_.empty()) return;
    auto& element = *open_.back();
    if (element.text.empty()) {
      const auto first = std::find_if_not(text.begin(), text.end(), is_space);
      if (first == text.end()) return;
      element.text_position = here();
      element.text_position.column += static_cast<std::uint32_t>(first - text.begin());
      text.remove_prefix(static_cast<std::size_t>(first - text.begin()));
    }
    element.text.append(text);
  }

  std::string_view text_;
  std::uint32_t file_;
  Diagnostics& diagnostics_;
  XML_Parser parser_;
  std::unique_ptr<Element> root_;
  std::vector<Element*> open_;  // a child's address holds until its parent gets the next child
  std::size_t elements_ = 0;
  bool stopped_{};
};

}  // namespace

std::unique_ptr<Element> parse_xml(std::string_view text, std::uint32_t file,
                                   Diagnostics& diagnostics) {
  return Reader(text, file, diagnostics).run();
}

}  // namespace cas::mav::xml
