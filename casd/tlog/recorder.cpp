// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/recorder.hpp"

#include <fmt/format.h>
#include <chrono>
#include <filesystem>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "casd/tlog/log_folder.hpp"
#include "casd/tlog/tlog_name.hpp"

namespace cas::casd {
namespace {

std::string dated(std::string_view name) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return dated_tlog_name(std::chrono::duration_cast<std::chrono::seconds>(now), name);
}

}  // namespace

Recorder::Recorder(TlogWriter& writer, TlogConfig config)
    : writer_(writer), config_(std::move(config)) {
  // Clients of the command port have other working folders.
  config_.folder =
      std::filesystem::absolute(config_.folder.empty() ? "." : config_.folder).lexically_normal();
  if (!config_.folder.has_filename()) config_.folder = config_.folder.parent_path();
}

void Recorder::begin() {
  if (config_.while_armed) return writer_.stand_by(LogFolder(config_.folder), config_.keep);
  if (config_.tlog.empty()) return;
  TlogRecording::Options wanted = options(config_.tlog, config_.rotation);
  if (config_.overwrite) wanted.files.name = bare_tlog_name(config_.tlog);
  wanted.files.overwrite = config_.overwrite;
  writer_.start(std::move(wanted));
}

void Recorder::start(const std::string& name, const TlogRotation& rotation, TlogWriter::Done done) {
  if (const auto fault = tlog_name_fault(name); fault && !name.empty()) {
    throw base::ConfigError("a recording has a name in " + config_.folder.string() +
                            ", and this one " + *fault);
  }
  of_flight_ = false;
  writer_.start(options(name, rotation), std::move(done));
}

void Recorder::stop(TlogWriter::Done done) {
  of_flight_ = false;
  writer_.stop(std::move(done));
}

void Recorder::stop() {
  of_flight_ = false;
  writer_.stop();
}

void Recorder::on_vehicles(bool any_armed, base::RunTime now) {
  if (!config_.while_armed) return;
  const bool open = window_.update(any_armed, now);
  if (open == std::exchange(flying_, open)) return;
  if (open && !writer_.active()) {
    TlogRecording::Options wanted = options(config_.tlog, config_.rotation);
    wanted.insist = true;
    writer_.start(std::move(wanted), [](const auto&, const TlogStatus& status) {
      if (status.file.empty()) return;  // it pauses, and the log says so already
      base::log::info("a vehicle is armed: recording into " + status.file.string());
    });
    of_flight_ = true;
  } else if (!open && std::exchange(of_flight_, false)) {
    writer_.stop([](const auto&, const TlogStatus& status) {
      const std::string missing =
          status.left_out == 0 ? "" : fmt::format("; {} are missing", status.left_out);
      base::log::info(fmt::format("no vehicle is armed any more: recorded {} packets{}",
                                  status.recorded, missing));
    });
  }
}

TlogRecording::Options Recorder::options(const std::string& name,
                                         const TlogRotation& rotation) const {
  TlogRecording::Options options;
  options.files.folder = config_.folder;
  options.files.name = dated(bare_tlog_name(name));
  options.files.rotation = rotation;
  options.files.max_files = config_.keep.max_files;
  options.limits = config_.keep;
  return options;
}

}  // namespace cas::casd
