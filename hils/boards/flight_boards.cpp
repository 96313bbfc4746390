// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/flight_boards.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/boards/board_actions.hpp"
#include "hils/boards/board_device.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_log.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::size_t place_of(const std::string& name, const VehicleNames& vehicles) {
  const auto found = std::ranges::find(vehicles, name);
  if (found != vehicles.end()) return static_cast<std::size_t>(found - vehicles.begin());
  throw base::ConfigError(fmt::format("--fcu: there is no vehicle '{}'; vehicles are {}", name,
                                      fmt::join(vehicles, ", ")));
}

/// Checks the file without opening it, because opening may restart a board.
/// @throws base::ConfigError
void refuse_what_is_no_terminal(const std::string& path) {
  constexpr unsigned kMemoryDevices = 1;  // major number of /dev/null, /dev/zero. Source: [Linux]
                                          // admin-guide/devices.txt
  struct stat is {};
  if (::stat(path.c_str(), &is) != 0) return;  // absent: opening reports it
  if (S_ISCHR(is.st_mode) && major(is.st_rdev) != kMemoryDevices) return;
  throw base::ConfigError("--fcu " + path + ": " + path + " is not a terminal");
}

FcuDevice device_of(const Board& board, const fs::path& port, std::optional<unsigned> baud) {
  return {.path = port.string(),
          .baud = baud.value_or(board.baud),
          .sensors_path = board.sensors_device.string(),
          .outputs_disconnected = board.outputs_disconnected};
}

Json board_json(const std::string& vehicle, const Board& board, const BoardFacts& facts) {
  return {{"vehicle", vehicle},
          {"board", board.name},
          {"kind", board.kind},
          {"serial", board.serial},
          {"device", facts.device.string()},
          {"autopilot", facts.autopilot},
          {"firmware", facts.firmware},
          {"commit", facts.commit},
          {"calibration", to_string(board.calibration)}};
}

}  // namespace

std::vector<FcuChoice> parse_fcu_words(const std::vector<std::string>& words,
                                       const VehicleNames& vehicles) {
  std::vector<FcuChoice> choices;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const bool names_vehicle = equals != std::string::npos && equals < word.find('/');
    if (!names_vehicle && vehicles.size() > 1) {
      throw base::ConfigError(
          fmt::format("--fcu {}: the scenario has several vehicles: say which one, --fcu {}={}",
                      word, vehicles.front(), word));
    }
    FcuChoice choice{.controller = names_vehicle ? word.substr(equals + 1) : word};
    if (names_vehicle) choice.vehicle = place_of(word.substr(0, equals), vehicles);
    if (choice.controller.empty()) throw base::ConfigError("--fcu " + word + ": names no board");
    for (const FcuChoice& other : choices) {
      if (other.vehicle == choice.vehicle) {
        throw base::ConfigError("--fcu: vehicle '" + vehicles[choice.vehicle] +
                                "' has two controllers");
      }
      if (other.controller == choice.controller) {
        throw base::ConfigError("--fcu: " + choice.controller + " cannot fly two vehicles");
      }
    }
    choices.push_back(std::move(choice));
  }
  return choices;
}

bool is_board(const std::string& controller, const BoardList* list, bool is_path) {
  if (controller.find('/') != std::string::npos) return false;
  if (list == nullptr) {
    if (is_path) return false;
    throw base::ConfigError("--fcu " + controller +
                            ": no port of the working folder has this name, and " +
                            no_board_list());
  }
  if (list->find(controller) != nullptr) return true;
  if (!is_path) list->board(controller);  // its error names the boards
  return false;
}

void fail_absent(const std::map<std::size_t, std::string>& gone, RunResult& run) {
  bool any = false;
  for (const auto& [vehicle, sentence] : gone) {
    Verdict& verdict = run.vehicles.at(vehicle).verdict;
    if (verdict.passed) continue;
    verdict.valid = any = true;
    verdict.failures.insert(verdict.failures.begin(), sentence);
  }
  if (!any) return;
  run.verdict = run.has_several() ? judge_together(run.vehicles) : run.vehicles.front().verdict;
  run.verdict.valid = true;
}

FlightBoards::FlightBoards(const std::vector<FcuChoice>& choices, const fs::path& file,
                           const std::string& purpose, std::optional<base::Duration> wait) {
  if (choices.empty()) return;
  if (!file.empty()) list_ = BoardList::load(file);
  std::vector<const Board*> in_order;
  for (const FcuChoice& choice : choices) {
    std::error_code error;
    const bool is_path = fs::exists(choice.controller, error);
    if (is_board(choice.controller, list_ ? &*list_ : nullptr, is_path)) {
      in_order.push_back(boards_[choice.vehicle] = &list_->board(choice.controller));
    } else {
      refuse_what_is_no_terminal(choice.controller);
      ports_[choice.vehicle] = choice.controller;
      if (const Board* board = board_at(choice.controller)) in_order.push_back(board);
    }
  }
  if (in_order.empty()) return;
  std::ranges::sort(in_order, {}, [](const Board* board) { return board->identity(); });
  if (std::ranges::adjacent_find(in_order) != in_order.end()) {
    throw base::ConfigError("--fcu: a board cannot fly two vehicles");
  }
  const fs::path folder = lock_folder(*list_);
  for (const Board* board : in_order) locks_.emplace_back(*board, folder, purpose, wait);
}

const Board* FlightBoards::board_at(const fs::path& port) const {
  std::error_code error;
  const fs::path wanted = fs::canonical(port, error);
  if (!list_ || error) return nullptr;
  const auto found = std::ranges::find_if(list_->boards, [&](const Board& board) {
    const auto device = find_device(board, list_->by_id);
    return device && fs::canonical(*device, error) == wanted;
  });
  return found == list_->boards.end() ? nullptr : &*found;
}

FcuDevice FlightBoards::device(std::size_t vehicle, std::optional<unsigned> baud) const {
  if (const auto port = ports_.find(vehicle); port != ports_.end()) {
    if (const auto missing = missing_port()) throw BoardError(kExitBoardAbsent, *missing);
    return {.path = port->second, .baud = baud.value_or(FcuDevice{}.baud)};
  }
  const Board& board = *boards_.at(vehicle);
  const auto found = find_device(board, list_->by_id);
  if (!found) throw BoardError(kExitBoardAbsent, judge_boot({}, board).sentence);
  return device_of(board, *found, baud);
}

void FlightBoards::restart(const fs::path& logs, std::optional<unsigned> baud) const {
  Supervisor supervisor;
  for (const auto& [vehicle, board] : boards_) {
    BoardActions(supervisor, *list_, *board, logs).restart();
  }
  const BoardList none;
  for (const auto& [vehicle, port] : ports_) {
    const Board board{.name = port, .device = port, .baud = baud.value_or(FcuDevice{}.baud)};
    BoardActions(supervisor, none, board, logs).restart();
  }
}

std::map<std::size_t, FcuDevice> FlightBoards::prepare(const fs::path& out,
                                                       const VehicleNames& vehicles,
                                                       std::optional<unsigned> baud) const {
  std::map<std::size_t, FcuDevice> devices;
  for (const auto& [vehicle, port] : ports_) {
    devices[vehicle] = {.path = port, .baud = baud.value_or(FcuDevice{}.baud)};
  }
  if (boards_.empty()) return devices;
  Supervisor supervisor;
  Json all = Json::array();
  for (const auto& [vehicle, board] : boards_) {
    const BoardFacts facts = BoardActions(supervisor, *list_, *board, out).boot(Absence::kFails);
    if (board->calibration == Calibration::kMissing) {
      fmt::print(stderr,
                 "board '{}': by boards.yaml its sensors are not calibrated: a stock firmware may "
                 "refuse to arm\n",
                 board->name);
    }
    devices[vehicle] = device_of(*board, facts.device, baud);
    all.push_back(board_json(vehicles.at(vehicle), *board, facts));
  }
  base::write_result({out, "boards.json"}, all.dump(2) + "\n");
  return devices;
}

void FlightBoards::fetch_logs(const fs::path& out, const VehicleNames& vehicles) const {
  for (const auto& [vehicle, board] : boards_) {
    if (!board->log) continue;
    Supervisor supervisor;  // a program of one that ends stops no other
    const fs::path folder = vehicles.size() > 1 ? out / vehicles.at(vehicle) : out;
    base::make_result_folder({out, folder});
    base::remove_result({folder, "board.ulg"});  // that of a flight before
    fmt::print(stderr, "{}\n",
               fetch_newest_log(supervisor, *board, list_->by_id, folder / "board.ulg").sentence);
  }
}

base::Duration FlightBoards::log_time() const {
  base::Duration time{};
  for (const auto& [vehicle, board] : boards_) {
    if (board->log) time += board->log->timeout;
  }
  return time;
}

std::optional<std::string> FlightBoards::missing_port() const {
  const auto found = std::ranges::find_if(ports_, [](const auto& port) {
    std::error_code error;
    return !fs::exists(port.second, error);
  });
  if (found == ports_.end()) return std::nullopt;
  return found->second + ": there is no such port";
}

std::map<std::size_t, std::string> FlightBoards::absences() const {
  std::map<std::size_t, std::string> sentences;
  for (const auto& [vehicle, board] : boards_) {
    if (find_device(*board, list_->by_id)) continue;
    sentences[vehicle] = judge_boot({}, *board).sentence + "; it was there when the run began";
  }
  return sentences;
}

}  // namespace cas::hils
