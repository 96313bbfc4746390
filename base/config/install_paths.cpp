// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/install_paths.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "base/error.hpp"
#include "base/suggestion.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

fs::path program_dir() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path();
}

/// Folder of the library that holds this code.
fs::path library_dir() {
  Dl_info info{};
  if (::dladdr(reinterpret_cast<const void*>(&config_dirs), &info) == 0) return {};
  std::error_code error;
  const fs::path library = fs::canonical(info.dli_fname, error);
  return error ? fs::path() : library.parent_path();
}

void add_folder(const fs::path& folder, std::vector<fs::path>& folders) {
  std::error_code error;
  const fs::path clean = fs::canonical(folder, error);
  if (error || !fs::is_directory(clean, error)) return;
  if (std::find(folders.begin(), folders.end(), clean) == folders.end()) folders.push_back(clean);
}

void add_from_environment(const char* variable, std::vector<fs::path>& folders) {
  const char* const value = std::getenv(variable);
  if (value == nullptr) return;
  std::istringstream list(value);
  for (std::string folder; std::getline(list, folder, ':');) {
    if (!folder.empty()) add_folder(folder, folders);
  }
}

void add_relative(const fs::path& from, const char* steps, std::vector<fs::path>& folders) {
  if (!from.empty()) add_folder(from / steps, folders);
}

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::exists(file, error) && !fs::is_directory(file, error);
}

/// "../../vehicles/x.yaml" relative to a folder with configuration: "vehicles/x.yaml".
fs::path without_steps_up(const fs::path& name) {
  fs::path below;
  for (const fs::path& part : name.lexically_normal()) {
    if (part != "..") below /= part;
  }
  return below;
}

/// Files of the same kind in a folder and the folders of it, by their paths from there.
void add_files(const fs::path& folder, const fs::path& extension, std::vector<std::string>& files,
               std::vector<std::string>& stems) {
  constexpr std::size_t kMost = 2000;  // a home folder may hold any number
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied,
                                         error);
  for (std::size_t seen = 0; !error && entry != fs::recursive_directory_iterator() && seen < kMost;
       entry.increment(error), ++seen) {
    if (entry.depth() > 0) entry.disable_recursion_pending();
    if (entry->path().extension() != extension) continue;
    files.push_back(entry->path().lexically_relative(folder).string());
    stems.push_back(entry->path().stem().string());
  }
}

/// "; did you mean scenarios/hover.yaml?" for hoover.yaml and for hover, or nothing: files that are
/// shipped, and those of `folder`, where one is given.
/// @param key  that names the file: what "vehicle" names lies in vehicles/
std::string meant_shipped(fs::path name, const fs::path& folder = {}, std::string key = {}) {
  if (!name.has_extension()) name.replace_extension(".yaml");
  std::vector<std::string> files;
  std::vector<std::string> stems;
  if (!folder.empty()) add_files(folder, name.extension(), files, stems);
  for (const fs::path& shipped : config_dirs()) {
    add_files(shipped, name.extension(), files, stems);
  }
  const std::string near = nearest_word(name.stem().string(), stems);
  if (near.empty()) return {};
  // If several files have this name, suggest those in the folder that was named, else all.
  if (!key.empty()) key.pop_back();  // "topolog" of topologies/
  const auto names_folder = [&](const fs::path& wanted) {
    const fs::path parent = name.parent_path();
    if (!parent.empty()) return std::find(parent.begin(), parent.end(), wanted) != parent.end();
    return !key.empty() && wanted.string().starts_with(key);
  };
  std::string meant;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (stems[i] != near) continue;
    if (names_folder(fs::path(files[i]).parent_path().filename())) {
      meant = files[i];
      break;
    }
    meant += (meant.empty() ? "" : " or ") + files[i];
  }
  return "; did you mean " + meant + "?";
}

}  // namespace

std::vector<fs::path> config_dirs() {
  std::vector<fs::path> folders;
  add_from_environment("CAS_CONFIG_PATH", folders);
  add_relative(program_dir(), CAS_BIN_TO_CONFIG, folders);
  add_relative(library_dir(), CAS_LIB_TO_CONFIG, folders);
  add_relative(library_dir(), "../share/cas/config", folders);  // build tree: a link to config/
  return folders;
}

std::vector<fs::path> plugin_dirs() {
  std::vector<fs::path> folders;
  add_from_environment("CAS_PLUGIN_PATH", folders);
  add_relative(program_dir(), CAS_BIN_TO_PLUGINS, folders);
  add_relative(library_dir(), CAS_LIB_TO_PLUGINS, folders);
  add_relative(library_dir(), "../plugins", folders);  // build tree
  return folders;
}

std::optional<fs::path> web_dir() {
  std::vector<fs::path> folders;
  add_from_environment("CAS_WEB_PATH", folders);
  // Beside the configuration, before symlinks are followed: in the build tree that one is a link.
  const auto add_beside = [&folders](const fs::path& from, const char* steps) {
    if (!from.empty()) add_folder((from / steps).lexically_normal().parent_path() / "web", folders);
  };
  add_beside(program_dir(), CAS_BIN_TO_CONFIG);
  add_beside(library_dir(), CAS_LIB_TO_CONFIG);
  add_beside(library_dir(), "../share/cas/config");
  for (const fs::path& folder : folders) {
    if (is_there(folder / "index.html")) return folder;
  }
  return std::nullopt;
}

fs::path find_config(const fs::path& name) {
  std::error_code error;
  if (fs::exists(name, error)) return name;
  if (name.is_absolute()) throw ConfigError(name.string() + ": no such file");
  std::string searched = "here";
  for (const fs::path& folder : config_dirs()) {
    if (fs::exists(folder / name, error)) return folder / name;
    searched += " or in " + folder.string();
  }
  throw ConfigError(name.string() + ": no such file " + searched + meant_shipped(name));
}

fs::path shipped_config(const std::string& name) {
  for (const fs::path& folder : config_dirs()) {
    if (is_there(folder / name)) return folder / name;
  }
  throw ConfigError(name + ": is in no folder of shipped configuration");
}

fs::path find_config(const ConfigNode& node) {
  const fs::path name = node.as<std::string>();
  if (name.empty()) node.fail("names no file");
  const fs::path beside = node.resolve(name.string());
  if (is_there(beside)) return beside;
  if (name.is_absolute()) node.fail("there is no file " + name.string());
  std::string searched = fs::absolute(beside).parent_path().string();
  for (const fs::path& folder : config_dirs()) {
    fs::path shipped = folder / without_steps_up(name);
    if (is_there(shipped)) return shipped;
    searched += " or below " + folder.string();
  }
  const std::string path = node.path();
  node.fail("there is no file '" + name.string() + "'; looked in " + searched +
            meant_shipped(name, beside.parent_path(), path.substr(path.rfind('.') + 1)));
}

}  // namespace cas::base
