// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/flight_logs.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "base/os/result_file.hpp"
#include "base/read_file.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

void FlightLogs::set_aside() {
  earlier_.push_back(folder_ / fmt::format("flight_{}.tlog", earlier_.size() + 1));
  std::filesystem::rename(log_, earlier_.back());
}

void FlightLogs::join() {
  if (earlier_.empty()) return;
  const std::filesystem::path last = folder_ / "flight_last.tlog";
  std::filesystem::rename(log_, last);
  earlier_.push_back(last);
  const base::OpenFile whole = base::open_result({log_.parent_path(), log_.filename()});
  for (const std::filesystem::path& part : earlier_) {
    const std::string text = base::read_file(part).value_or("");
    std::fwrite(text.data(), 1, text.size(), whole.get());
  }
  if (std::fflush(whole.get()) != 0 || std::ferror(whole.get()) != 0) {
    throw RunStopped(log_.string() + " cannot be written", false);
  }
}

}  // namespace cas::hils
