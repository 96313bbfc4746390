// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/key_path.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <span>

#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(std::string_view path, const std::string& sentence) {
  throw base::ConfigError(fmt::format("'{}': {}", path, sentence));
}

bool is_key_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == ' ';
}

KeyStep parse_step(std::string_view path, std::string_view text) {
  KeyStep step;
  const std::size_t open = text.find('[');
  step.key = text.substr(0, open);
  if (open != std::string_view::npos) {
    if (!text.ends_with("]")) fail(path, "a '[' has no ']'");
    step.element = text.substr(open + 1, text.size() - open - 2);
    if (step.element->empty()) fail(path, "nothing stands between '[' and ']'");
  }
  if (step.key.empty() || !std::ranges::all_of(step.key, is_key_character)) {
    fail(path, "is no path of keys such as line.packet_loss or plugins[wind].mean_m_s");
  }
  return step;
}

/// Documents that are written together: the scenario and the files that it names.
class Draft {
 public:
  Draft(fs::path folder, fs::path files_from)
      : folder_(std::move(folder)), files_from_(std::move(files_from)) {}

  /// The document of a file, its names of files absolute.
  static YAML::Node open(const fs::path& file) {
    YAML::Node root = YAML::Load(base::ConfigNode::load(file).dump());
    make_absolute(root, fs::absolute(file).parent_path());
    return root;
  }

  /// Sets the value at the end of the steps, below `node`. @param path  for errors
  void set(YAML::Node node, std::span<const KeyStep> steps, const std::string& path,
           const std::string& value) {
    const KeyStep& step = steps.front();
    if (!node.IsMap()) fail(path, fmt::format("there is no map with the key '{}'", step.key));
    const bool last = steps.size() == 1;
    if (step.element) {
      YAML::Node list = node[step.key];
      if (!list) {
        fail(path, fmt::format("the file has no '{0}'; give all of it: '{0}=[...]'", step.key));
      }
      if (!list.IsSequence()) fail(path, fmt::format("'{}' is no list", step.key));
      const std::size_t index = element_of(list, *step.element, path);
      if (last) {
        list[index] = content(value);
      } else {
        set(inner(list[index], *step.element), steps.subspan(1), path, value);
      }
      return;
    }
    if (last) {
      if (value == "null") {
        node.remove(step.key);
      } else {
        node[step.key] = content(value);
      }
      return;
    }
    descend(node, steps, path, value);
  }

  /// Makes a copy of the file that a key names part of the draft.
  void copy_file(YAML::Node node, const std::string& key) {
    if (node[key] && node[key].IsScalar()) document_of(node, key);
  }

  void write(const YAML::Node& scenario) const {
    fs::create_directories(folder_);
    write_document(folder_ / "scenario.yaml", scenario);
    for (const auto& [name, document] : documents_) write_document(folder_ / name, document);
  }

 private:
  void descend(YAML::Node node, std::span<const KeyStep> steps, const std::string& path,
               const std::string& value) {
    const std::string& key = steps.front().key;
    if (!node[key] || node[key].IsNull()) {
      node[key] = YAML::Node(YAML::NodeType::Map);
    } else if (node[key].IsScalar() && key == "sensors") {
      YAML::Node block(YAML::NodeType::Map);
      block["preset"] = node[key].as<std::string>();
      node[key] = block;
    } else if (node[key].IsScalar()) {
      set(document_of(node, key), steps.subspan(1), path, value);
      return;
    }
    set(node[key], steps.subspan(1), path, value);
  }

  /// The document of the file that node[key] names, which from now on is the draft's own copy.
  YAML::Node document_of(YAML::Node node, const std::string& key) {
    const auto text = node[key].as<std::string>();
    if (const auto known = documents_.find(text); known != documents_.end()) return known->second;
    YAML::Node name_of_file(YAML::NodeType::Map);
    name_of_file[key] = text;
    const fs::path file =
        base::find_config(base::ConfigNode::parse(YAML::Dump(name_of_file), "scenario").at(key));
    std::string name = key + "_" + file.filename().string();
    for (int number = 2; documents_.contains(name); ++number) {
      name = fmt::format("{}{}_{}", key, number, file.filename().string());
    }
    YAML::Node document = open(file);
    documents_.emplace(name, document);
    node[key] = name;
    return document;
  }

  /// A value that names a file of the study becomes its absolute path.
  YAML::Node content(const std::string& value) const {
    YAML::Node node = YAML::Load(value);
    make_absolute(node, files_from_);
    return node;
  }

  /// A step of a flight is a map with one key, whose name leads to its inside.
  static YAML::Node inner(YAML::Node element, const std::string& word) {
    if (element.IsMap() && element.size() == 1 && element[word] && element[word].IsMap()) {
      return element[word];
    }
    return element;
  }

  static bool is_called(const YAML::Node& element, const std::string& word) {
    if (!element.IsMap()) return false;
    for (const char* key : {"name", "plugin"}) {
      if (element[key] && element[key].IsScalar() && element[key].as<std::string>() == word) {
        return true;
      }
    }
    if (element.size() != 1 || !element.begin()->second.IsMap()) return false;
    const YAML::Node inside = element.begin()->second;
    const bool named = inside["name"] && inside["name"].as<std::string>() == word;
    return named || element.begin()->first.as<std::string>() == word;
  }

  static std::size_t element_of(const YAML::Node& list, const std::string& word,
                                const std::string& path) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    if (error == std::errc{} && end == word.data() + word.size()) {
      if (index < list.size()) return index;
      fail(path, fmt::format("the list has {} entries, counted from 0", list.size()));
    }
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (is_called(list[i], word)) found.push_back(i);
    }
    if (found.empty()) fail(path, fmt::format("no entry of the list is called '{}'", word));
    if (found.size() > 1) {
      fail(path, fmt::format("{} entries of the list are called '{}'; count them from 0 instead",
                             found.size(), word));
    }
    return found.front();
  }

  static void make_absolute(YAML::Node node, const fs::path& folder) {
    if (node.IsMap()) {
      for (auto entry : node) make_absolute(entry.second, folder);
    } else if (node.IsSequence()) {
      for (auto entry : node) make_absolute(entry, folder);
    } else if (node.IsScalar()) {
      const std::string& text = node.Scalar();
      const bool may_be_file = text.find_first_of("./") != std::string::npos &&
                               text.find('\n') == std::string::npos && text.size() < 4096;
      if (!may_be_file || folder.empty()) return;
      std::error_code error;
      const fs::path file = fs::path(folder) / text;
      const bool is_folder = text.find('/') != std::string::npos && fs::is_directory(file, error);
      if (!fs::is_regular_file(file, error) && !is_folder) return;
      node = fs::weakly_canonical(file).string();
    }
  }

  static void write_document(const fs::path& file, const YAML::Node& document) {
    YAML::Emitter emitter;
    emitter << document;
    base::write_result({file.parent_path(), file.filename()}, std::string(emitter.c_str()) + "\n");
  }

  fs::path folder_;
  fs::path files_from_;
  std::map<std::string, YAML::Node> documents_;  ///< by the names of their files
};

}  // namespace

std::vector<KeyStep> parse_key_path(std::string_view path) {
  std::vector<KeyStep> steps;
  std::string_view rest = path;
  while (true) {
    // A dot between brackets belongs to the word there.
    const std::size_t open = rest.find('[');
    std::size_t dot = rest.find('.');
    if (open < dot) dot = rest.find('.', std::min(rest.find(']', open), rest.size()));
    steps.push_back(parse_step(path, rest.substr(0, dot)));
    if (dot == std::string_view::npos) return steps;
    rest.remove_prefix(dot + 1);
  }
}

void write_scenario(const std::filesystem::path& scenario, const std::vector<KeyValue>& values,
                    const std::filesystem::path& files_from, const std::filesystem::path& folder,
                    const std::vector<std::string>& copied) {
  Draft draft(folder, files_from);
  YAML::Node root = Draft::open(scenario);
  try {
    for (const auto& [path, value] : values) draft.set(root, parse_key_path(path), path, value);
    for (const std::string& key : copied) {
      draft.copy_file(root, key);
      if (!root["vehicles"] || !root["vehicles"].IsSequence()) continue;
      for (YAML::Node vehicle : root["vehicles"]) draft.copy_file(vehicle, key);
    }
  } catch (const YAML::Exception& error) {
    throw base::ConfigError(scenario.string() + ": " + error.what());
  }
  draft.write(root);
}

}  // namespace cas::hils
