// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "casd/words/external_ahrs_params.hpp"
#include "hils/boards/board_list.hpp"
#include "hils/boards/boot_check.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// A casd of its own on a board's serial port, while the object is there. It knows nothing of the
/// board from before.
class BoardSession {
 public:
  /// @param peer_port  UDP port of this machine to which all packets are passed on, and from which
  ///                   they are; 0: none
  /// @throws RunStopped, base::ConfigError
  BoardSession(Supervisor& supervisor, const Board& board, std::filesystem::path device,
               std::uint16_t peer_port = 0);
  ~BoardSession();
  BoardSession(const BoardSession&) = delete;
  BoardSession& operator=(const BoardSession&) = delete;

  const std::filesystem::path& device() const;
  /// The facts known now. @throws base::rpc::ConnectionError, base::rpc::CallError
  BoardFacts look();
  /// Has it say its version again: at first it may not have been ready to.
  void ask_version();
  /// Time since the board began, s, as SYSTEM_TIME says; nullopt while none has come. The first
  /// call begins to look.
  std::optional<double> uptime_s();
  /// When the board began, by the newest SYSTEM_TIME and when that came.
  std::optional<base::RunTime> began();
  /// Has it disarm, in the air, too. @throws BoardError (kExitBoardFailed) when it refuses
  void disarm();
  /// All its parameters. @throws BoardError (kExitBoardFailed) when it does not tell them
  casd::ParamValues params();
  /// @throws BoardError (kExitBoardFailed) when it is refused, or another value is in force
  void set_param(const std::string& name, double value);
  /// Has the board restart. @throws BoardError (kExitBoardFailed) when it refuses or is silent
  void reboot();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::hils
