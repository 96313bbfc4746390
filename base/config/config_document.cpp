// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/config_document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>

#include "base/error.hpp"

namespace cas::base {
namespace {

constexpr int kMaxDepth = 64;
constexpr int kMaxNodes = 50'000;
constexpr const char* kTooManyNodes = "the file expands to over 50000 values";

int line_of(const YAML::Mark& mark) { return mark.is_null() ? 0 : mark.line + 1; }

/// Copies yaml-cpp's graph into a tree and refuses errors that yaml-cpp accepts.
class TreeBuilder {
 public:
  explicit TreeBuilder(std::string name) : name_(std::move(name)) {}

  void build(const YAML::Node& node, ConfigTree& tree, const std::string& path, int depth) {
    if (tree.line == 0) tree.line = line_of(node.Mark());
    if (depth > kMaxDepth) fail(tree.line, path, "is nested deeper than 64 levels");
    if (++nodes_ > kMaxNodes) fail(tree.line, path, kTooManyNodes);
    if (node.IsScalar()) {
      tree.kind = ConfigTree::Kind::kScalar;
      tree.scalar = node.Scalar();
      tree.quoted = node.Tag() == "!";
    } else if (node.IsSequence()) {
      build_list(node, tree, path, depth);
    } else if (node.IsMap()) {
      build_map(node, tree, path, depth);
    }
  }

  [[noreturn]] void fail(int line, const std::string& path, const std::string& sentence) const {
    std::string where = name_;
    if (line > 0) where += ":" + std::to_string(line);
    if (!path.empty()) where += ": " + path;
    throw ConfigError(where + ": " + sentence);
  }

 private:
  void build_list(const YAML::Node& node, ConfigTree& tree, const std::string& path, int depth) {
    tree.kind = ConfigTree::Kind::kList;
    for (std::size_t i = 0; i < node.size(); ++i) {
      auto child = std::make_unique<ConfigTree>();
      build(node[i], *child, path + "[" + std::to_string(i) + "]", depth + 1);
      tree.items.push_back(std::move(child));
    }
  }

  void build_map(const YAML::Node& node, ConfigTree& tree, const std::string& path, int depth) {
    tree.kind = ConfigTree::Kind::kMap;
    for (const auto& entry : node) {
      const int line = line_of(entry.first.Mark());
      if (!entry.first.IsScalar()) fail(line, path, "a key must be a word");
      const std::string& key = entry.first.Scalar();
      const std::string child_path = path.empty() ? key : path + "." + key;
      if (const ConfigTree* first = tree.find(key)) {
        fail(line, child_path, "repeats the key of line " + std::to_string(first->line));
      }
      auto child = std::make_unique<ConfigTree>();
      child->line = line;
      build(entry.second, *child, child_path, depth + 1);
      tree.places.emplace(key, tree.entries.size());
      tree.entries.emplace_back(key, std::move(child));
    }
  }

  std::string name_;
  int nodes_ = 0;
};

/// Marks where the documents of a text begin, and counts values before yaml-cpp keeps any.
class TextScan : public YAML::EventHandler {
 public:
  explicit TextScan(const TreeBuilder& builder) : builder_(builder) {}

  std::vector<YAML::Mark> begins;

  void OnDocumentStart(const YAML::Mark& mark) override { begins.push_back(mark); }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string&) override {
    count(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    count(mark);
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    count(mark);
  }
  void OnMapEnd() override {}

 private:
  // Each key is an event, too, but counts as no value.
  void count(const YAML::Mark& mark) {
    if (++events_ > 2 * kMaxNodes) builder_.fail(line_of(mark), "", kTooManyNodes);
  }

  const TreeBuilder& builder_;
  int events_ = 0;
};

/// Refuses a text of several documents or of too many values. yaml-cpp makes documents without end
/// of a mark that belongs to no value, such as a comma alone, so two are asked for and no more.
void scan_text(const std::string& text, const TreeBuilder& builder) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  TextScan scan(builder);
  while (scan.begins.size() < 2 && parser.HandleNextDocument(scan)) {
  }
  if (scan.begins.size() < 2) return;
  const YAML::Mark& second = scan.begins[1];
  if (second.pos == scan.begins[0].pos) {
    builder.fail(line_of(second), "",
                 "is not YAML: it begins with a mark that belongs to no value");
  }
  builder.fail(line_of(second), "", "holds more than one document");
}

void emit(YAML::Emitter& out, const ConfigTree& tree) {
  switch (tree.kind) {
    case ConfigTree::Kind::kNull:
      out << YAML::Null;
      break;
    case ConfigTree::Kind::kScalar:
      if (tree.quoted) out << YAML::DoubleQuoted;
      out << tree.scalar;
      break;
    case ConfigTree::Kind::kList:
      out << YAML::Flow << YAML::BeginSeq;
      for (const auto& item : tree.items) emit(out, *item);
      out << YAML::EndSeq;
      break;
    case ConfigTree::Kind::kMap:
      out << YAML::BeginMap;
      for (const auto& [key, child] : tree.entries) {
        out << YAML::Key << key << YAML::Value;
        emit(out, *child);
      }
      out << YAML::EndMap;
      break;
  }
}

/// @param line  from 1
bool indents_with_tab(std::string_view text, int line) {
  for (int i = 1; i < line; ++i) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return false;
    text.remove_prefix(end + 1);
  }
  const std::string_view blank = text.substr(0, text.find_first_not_of(" \t"));
  return line > 0 && blank.find('\t') != std::string_view::npos;
}

}  // namespace

const ConfigTree* ConfigTree::find(std::string_view key) const {
  const auto place = places.find(key);
  return place == places.end() ? nullptr : entries[place->second].second.get();
}

std::shared_ptr<const ConfigDocument> parse_config(std::string_view text,
                                                   const std::filesystem::path& name) {
  auto document = std::make_shared<ConfigDocument>();
  document->file = name;
  document->origins = ConfigOrigins::read(text);
  TreeBuilder builder(name.string());
  if (text.size() > kMaxConfigBytes) builder.fail(0, "", "is larger than 4 MiB");
  try {
    const std::string copy(text);
    scan_text(copy, builder);
    const YAML::Node node = YAML::Load(copy);
    if (node.IsDefined()) builder.build(node, document->root, "", 0);
  } catch (const YAML::Exception& error) {
    const int line = line_of(error.mark);
    for (const int tabbed : {line, line - 1}) {
      if (!indents_with_tab(text, tabbed)) continue;
      builder.fail(tabbed, "", "is not YAML: a tab is in the indentation; YAML takes spaces alone");
    }
    const bool no_end = error.msg.find("end of map not found") != std::string::npos ||
                        error.msg.find("end of sequence not found") != std::string::npos;
    const bool has_colon = error.msg.find("illegal map value") != std::string::npos;
    builder.fail(line, "",
                 "is not YAML: " + error.msg +
                     (no_end      ? "; perhaps indented differently from the line above"
                      : has_colon ? "; a text with ': ' in it needs quotes"
                                  : ""));
  }
  return document;
}

std::string dump_config(const ConfigTree& tree) {
  YAML::Emitter out;
  emit(out, tree);
  return out.c_str();
}

}  // namespace cas::base
