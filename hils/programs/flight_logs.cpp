// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/flight_logs.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/read_file.hpp"

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
  const base::ResultPlace place{log_.parent_path(), log_.filename()};
  base::OpenFile whole = base::open_result(place);
  for (const std::filesystem::path& part : earlier_) {
    const std::optional<std::string> text = base::read_file(part);
    if (!text) throw base::ConfigError(part.string() + ": a part of the flight log cannot be read");
    std::fwrite(text->data(), 1, text->size(), whole.get());
  }
  base::close_result(std::move(whole), place);
}

}  // namespace cas::hils
