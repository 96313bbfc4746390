// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/file_parser.hpp"

#include <array>
#include <utility>

#include "mavlink_gen/parser/element_reader.hpp"
#include "mavlink_gen/parser/numbers.hpp"

namespace cas::mav::xml {
namespace {

constexpr std::uint32_t kMaxVersion = 255;
constexpr std::uint32_t kMaxDialectNumber = 0x7FFFFFFF;

class FileParser final {
 public:
  explicit FileParser(Diagnostics& diagnostics) : reader_(diagnostics) {}

  ParsedFile parse(const Element& root) {
    if (root.name != "mavlink") {
      reader_.error(root.position, "the root element is <" + root.name + ">, not <mavlink>");
      return {};
    }
    constexpr std::array<std::string_view, 5> kChildren{"include", "version", "dialect", "enums",
                                                        "messages"};
    for (const auto& child : root.children) {
      if (!reader_.expect_child(root, child, kChildren)) continue;
      if (child.name == "include") parse_include(child);
      if (child.name == "version") parse_count(child, kMaxVersion, file_.version);
      if (child.name == "dialect") parse_count(child, kMaxDialectNumber, file_.dialect);
      if (child.name == "enums") parse_enums(child);
      if (child.name == "messages") parse_messages(child);
    }
    return std::move(file_);
  }

 private:
  void parse_count(const Element& element, std::uint32_t max, std::optional<int>& out) {
    reader_.expect_attributes(element, {});
    const auto text = trimmed(element.text);
    const auto value = parse_number(text, max);
    if (!value) {
      reader_.error(element.text_position, "<" + element.name + "> holds " + in_quotes(text) +
                                               ", not a number from 0 to " + std::to_string(max));
    } else if (out) {
      reader_.error(element.position, "<" + element.name + "> stands twice");
    } else {
      out = static_cast<int>(*value);
    }
  }

  void parse_include(const Element& element) {
    reader_.expect_attributes(element, {});
    auto path = trimmed(element.text);
    if (path.empty()) {
      reader_.error(element.position, "<include> names no file");
    } else {
      file_.includes.push_back({std::move(path), element.position});
    }
  }

  void parse_enums(const Element& element) {
    constexpr std::array<std::string_view, 1> kChildren{"enum"};
    for (const auto& child : element.children) {
      if (!reader_.expect_child(element, child, kChildren)) continue;
      if (auto item = parse_enum(child, reader_)) file_.enums.push_back(std::move(*item));
    }
  }

  void parse_messages(const Element& element) {
    constexpr std::array<std::string_view, 1> kChildren{"message"};
    for (const auto& child : element.children) {
      if (!reader_.expect_child(element, child, kChildren)) continue;
      if (auto message = parse_message(child, reader_))
        file_.messages.push_back(std::move(*message));
    }
  }

  ElementReader reader_;
  ParsedFile file_;
};

}  // namespace

ParsedFile parse_file(const Element& root, Diagnostics& diagnostics) {
  return FileParser(diagnostics).parse(root);
}

}  // namespace cas::mav::xml
