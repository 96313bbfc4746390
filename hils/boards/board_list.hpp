// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {

/// Purpose of a hook.
enum class HookKind { kFlash, kPowerOn, kPowerOff, kReset, kConsole };
inline constexpr std::array kHookKinds{HookKind::kFlash, HookKind::kPowerOn, HookKind::kPowerOff,
                                       HookKind::kReset, HookKind::kConsole};

/// Key of the hook in boards.yaml: "power_on".
std::string_view to_string(HookKind kind);

/// A command of the user.
struct BoardHook {
  std::vector<std::string> command;  ///< argv; ${NAME} is a variable of the hook
  base::Duration timeout{};          ///< then it is ended; not of `console`
};

/// State of the sensors' calibration. In HIL the sensors are simulated, but stock firmware may
/// still refuse to arm without it.
enum class Calibration { kUnknown, kDone, kMissing };
std::string_view to_string(Calibration state);

/// How the newest log is fetched from a board after a flight.
struct BoardLog {
  std::string folder{};     ///< on the board, without a slash at its end
  double largest_mib = 64;  ///< of a log that is fetched
  base::Duration timeout = std::chrono::seconds(120);
};

/// One flight controller of the bench.
struct Board {
  std::string name{};
  std::string serial{};            ///< USB serial number; empty: `device` says where it is
  std::filesystem::path device{};  ///< path; empty: it is found by `serial`
  unsigned interface = 0;          ///< of a USB device with several serial ports: which
  unsigned baud = 921600;
  /// Port of this machine that leads to its External AHRS; empty: none (ArduPilot only).
  std::filesystem::path sensors_device{};
  /// The user's word that no motor, ESC or servo is connected to it.
  bool outputs_disconnected = false;
  std::string kind{};      ///< in the user's words
  std::string firmware{};  ///< version that it must say: "1.15.0", or its beginning; empty: any
  std::string commit{};    ///< beginning of the commit that it must say; empty: any
  Calibration calibration = Calibration::kUnknown;
  base::Duration boot_timeout = std::chrono::seconds(30);
  base::Duration off_time = std::chrono::seconds(2);  ///< without power in a power cycle
  std::optional<BoardLog> log{};                      ///< nullopt: it is not fetched
  std::map<HookKind, BoardHook> hooks{};

  /// Identity of the board in any list: its serial number, else its path.
  std::string identity() const { return serial.empty() ? device.string() : serial; }
};

/// Whether a commit can be compared: digits and small letters from a to f. Pure.
bool is_hexadecimal(std::string_view commit);

/// boards.yaml.
struct BoardList {
  std::filesystem::path file;
  std::filesystem::path lock_folder;                  ///< empty: the user's own in /var/tmp
  std::filesystem::path by_id = "/dev/serial/by-id";  ///< udev's links
  std::vector<Board> boards;

  /// @throws base::ConfigError with file, line and key path, and when the file may be the work of
  /// another user (base/os/trusted_file.hpp)
  static BoardList load(const std::filesystem::path& file);
  static BoardList parse(const base::ConfigNode& root);

  const Board* find(std::string_view name) const;
  /// @throws base::ConfigError for a name that it does not have
  const Board& board(std::string_view name) const;
};

/// Where boards.yaml is: `given` (--boards) if it is not empty, else the first that is there of
///   $CAS_BOARDS
///   $XDG_CONFIG_HOME/cas/boards.yaml   ~/.config/cas/boards.yaml where that is not set
///   /etc/cas/boards.yaml
/// Never in the working folder, which may be anybody's work. @return an empty path when there is
/// none
std::filesystem::path find_board_list(const std::filesystem::path& given);

/// That there is none, and where it was looked for.
std::string no_board_list();

}  // namespace cas::hils
